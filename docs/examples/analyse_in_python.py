"""Load, normalise, describe, fit, plot: the analysis in Python, as in a notebook.

Run it from anywhere: ``python docs/examples/analyse_in_python.py [FOLDER_FOR_THE_FIGURE]``. The
data is a data set that the paper's Table III allows, not the authors' (never published).
"""

# %%
import sys
from pathlib import Path

from analysis import figures, growth_models, inference, published, scaling
from analysis.descriptives import describe, table3
from analysis.loading import load
from analysis.normalisation import cell_means, normalise, normalise_by_all
from analysis.prepared import prepare

# %% Load: a data set's folder, or a table with participant_id, amplitude_um_pp, estimate
data = load(published.ALLOWED_DATASET)
print(data.counts["analysed"], "estimates;", "problems:", data.problems or "none")

# %% Normalise: which rules does the data allow, and what does one give?
print("rules:", ", ".join(normalise_by_all(data.estimates)))
estimates = data.estimates.assign(normalised=normalise(data.estimates, "grand_maximum"))

# %% Describe: the paper's Table III, then everything
cells = cell_means(estimates, "normalised")
print(table3(cells).round(2).to_string(index=False))
ready = prepare(estimates, data.choices)
print(describe(cells, ready.logs).round(2).to_string(index=False))

# %% Fit: the exponent, and which growth function is favoured
exponent = scaling.power_law(ready)
print(
    f"exponent {exponent['exponent']:.2f}, 95 % {exponent['ci95'][0]:.2f}-{exponent['ci95'][1]:.2f}"
)
growth = growth_models.compare(ready.logs)
print("favoured:", growth["best"])

# %% Test
print("Friedman:", inference.friedman(ready))

# %% Plot
figure = figures.fig15(cells)
where = Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd()
print("figure:", figures.save(figure, where / "fig15", (".svg",))[0].name)
