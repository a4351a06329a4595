"""List the papers that a methods section cites, as text and as BibTeX."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """A cited paper.

    Parameters
    ----------
    cited : str
        Citation for sentences, such as "Friedman, 1937".
    authors : str
        Authors as in BibTeX, joined by " and ".
    title, journal, pages : str
        As in BibTeX; page ranges have a hyphen.
    year : int
    volume : str
    """

    cited: str
    authors: str
    year: int
    title: str
    journal: str
    volume: str
    pages: str

    @property
    def listed(self) -> str:
        """Entry for a list of references."""
        names = self.authors.replace(" and others", " et al.").replace(" and ", "; ")
        return f"{names} ({self.year}). {self.title}. {self._place}."

    @property
    def _place(self) -> str:
        place = (self.journal, self.volume, self.pages.replace("-", "–"))
        return ", ".join(part for part in place if part)

    @property
    def found_at(self) -> str:
        """Reference without its title, such as "Holm, 1979. Journal, 6, 65–70."."""
        return f"{self.cited}. {self._place}."

    def bibtex(self, key: str) -> str:
        """Return the BibTeX entry."""
        fields = {
            "author": self.authors,
            "title": f"{{{self.title}}}",
            "journal": self.journal,
            "year": str(self.year),
            "volume": self.volume,
            "pages": self.pages.replace("-", "--"),
        }
        lines = "".join(f"  {name} = {{{value}}},\n" for name, value in fields.items() if value)
        return f"@article{{{key},\n{lines}}}\n"


#: Key in references.bib -> paper.
REFERENCES: dict[str, Reference] = {
    "friedman1937": Reference(
        cited="Friedman, 1937",
        authors="Friedman, M.",
        year=1937,
        title="The use of ranks to avoid the assumption of normality implicit in the analysis of "
        "variance",
        journal="Journal of the American Statistical Association",
        volume="32",
        pages="675-701",
    ),
    "wilcoxon1945": Reference(
        cited="Wilcoxon, 1945",
        authors="Wilcoxon, F.",
        year=1945,
        title="Individual comparisons by ranking methods",
        journal="Biometrics Bulletin",
        volume="1",
        pages="80-83",
    ),
    "sen1968": Reference(
        cited="Sen, 1968",
        authors="Sen, P. K.",
        year=1968,
        title="Estimates of the regression coefficient based on Kendall's tau",
        journal="Journal of the American Statistical Association",
        volume="63",
        pages="1379-1389",
    ),
    "tukey1963": Reference(
        cited="Tukey & McLaughlin, 1963",
        authors="Tukey, J. W. and McLaughlin, D. H.",
        year=1963,
        title="Less vulnerable confidence and significance procedures for location based on a "
        "single sample: trimming/Winsorization 1",
        journal="Sankhya A",
        volume="25",
        pages="331-352",
    ),
    "miller1956": Reference(
        cited="Miller, 1956",
        authors="Miller, G. A.",
        year=1956,
        title="The magical number seven, plus or minus two: some limits on our capacity for "
        "processing information",
        journal="Psychological Review",
        volume="63",
        pages="81-97",
    ),
    "kruskal1964": Reference(
        cited="Kruskal, 1964",
        authors="Kruskal, J. B.",
        year=1964,
        title="Multidimensional scaling by optimizing goodness of fit to a nonmetric hypothesis",
        journal="Psychometrika",
        volume="29",
        pages="1-27",
    ),
    "carroll1970": Reference(
        cited="Carroll & Chang, 1970",
        authors="Carroll, J. D. and Chang, J.-J.",
        year=1970,
        title="Analysis of individual differences in multidimensional scaling via an N-way "
        "generalization of 'Eckart-Young' decomposition",
        journal="Psychometrika",
        volume="35",
        pages="283-319",
    ),
    "laird1982": Reference(
        cited="Laird & Ware, 1982",
        authors="Laird, N. M. and Ware, J. H.",
        year=1982,
        title="Random-effects models for longitudinal data",
        journal="Biometrics",
        volume="38",
        pages="963-974",
    ),
    "hurvich1989": Reference(
        cited="Hurvich & Tsai, 1989",
        authors="Hurvich, C. M. and Tsai, C.-L.",
        year=1989,
        title="Regression and time series model selection in small samples",
        journal="Biometrika",
        volume="76",
        pages="297-307",
    ),
    "tukey1958": Reference(
        cited="Tukey, 1958",
        authors="Tukey, J. W.",
        year=1958,
        title="Bias and confidence in not quite large samples",
        journal="Annals of Mathematical Statistics",
        volume="29",
        pages="614",
    ),
    "holm1979": Reference(
        cited="Holm, 1979",
        authors="Holm, S.",
        year=1979,
        title="A simple sequentially rejective multiple test procedure",
        journal="Scandinavian Journal of Statistics",
        volume="6",
        pages="65-70",
    ),
    "greenhouse1959": Reference(
        cited="Greenhouse & Geisser, 1959",
        authors="Greenhouse, S. W. and Geisser, S.",
        year=1959,
        title="On methods in the analysis of profile data",
        journal="Psychometrika",
        volume="24",
        pages="95-112",
    ),
    "mcgraw1996": Reference(
        cited="McGraw & Wong, 1996",
        authors="McGraw, K. O. and Wong, S. P.",
        year=1996,
        title="Forming inferences about some intraclass correlation coefficients",
        journal="Psychological Methods",
        volume="1",
        pages="30-46",
    ),
    "olejnik2003": Reference(
        cited="Olejnik & Algina, 2003",
        authors="Olejnik, S. and Algina, J.",
        year=2003,
        title=(
            "Generalized eta and omega squared statistics: measures of effect size for some common "
            "research designs"
        ),
        journal="Psychological Methods",
        volume="8",
        pages="434-447",
    ),
    "page1963": Reference(
        cited="Page, 1963",
        authors="Page, E. B.",
        year=1963,
        title="Ordered hypotheses for multiple treatments: a significance test for linear ranks",
        journal="Journal of the American Statistical Association",
        volume="58",
        pages="216-230",
    ),
    "stevens1957": Reference(
        cited="Stevens, 1957",
        authors="Stevens, S. S.",
        year=1957,
        title="On the psychophysical law",
        journal="Psychological Review",
        volume="64",
        pages="153-181",
    ),
    "schuirmann1987": Reference(
        cited="Schuirmann, 1987",
        authors="Schuirmann, D. J.",
        year=1987,
        title=(
            "A comparison of the two one-sided tests procedure and the power approach for "
            "assessing the equivalence of average bioavailability"
        ),
        journal="Journal of Pharmacokinetics and Biopharmaceutics",
        volume="15",
        pages="657-680",
    ),
    "rouder2009": Reference(
        cited="Rouder et al., 2009",
        authors="Rouder, J. N. and Speckman, P. L. and Sun, D. and Morey, R. D. and Iverson, G.",
        year=2009,
        title="Bayesian t tests for accepting and rejecting the null hypothesis",
        journal="Psychonomic Bulletin & Review",
        volume="16",
        pages="225-237",
    ),
    "morey2008": Reference(
        cited="Morey, 2008",
        authors="Morey, R. D.",
        year=2008,
        title="Confidence intervals from normalized data: a correction to Cousineau (2005)",
        journal="Tutorials in Quantitative Methods for Psychology",
        volume="4",
        pages="61-64",
    ),
    "korn1998": Reference(
        cited="Korn & Graubard, 1998",
        authors="Korn, E. L. and Graubard, B. I.",
        year=1998,
        title=(
            "Confidence intervals for proportions with small expected number of positive counts "
            "estimated from survey data"
        ),
        journal="Survey Methodology",
        volume="24",
        pages="193-201",
    ),
    "wichmann2001": Reference(
        cited="Wichmann & Hill, 2001",
        authors="Wichmann, F. A. and Hill, N. J.",
        year=2001,
        title="The psychometric function: I. Fitting, sampling, and goodness of fit",
        journal="Perception & Psychophysics",
        volume="63",
        pages="1293-1313",
    ),
    "soukoreff2004": Reference(
        cited="Soukoreff & MacKenzie, 2004",
        authors="Soukoreff, R. W. and MacKenzie, I. S.",
        year=2004,
        title="Towards a standard for pointing device evaluation, perspectives on 27 years of "
        "Fitts' law research in HCI",
        journal="International Journal of Human-Computer Studies",
        volume="61",
        pages="751-789",
    ),
    "liang1986": Reference(
        cited="Liang & Zeger, 1986",
        authors="Liang, K.-Y. and Zeger, S. L.",
        year=1986,
        title="Longitudinal data analysis using generalized linear models",
        journal="Biometrika",
        volume="73",
        pages="13-22",
    ),
    "mancl2001": Reference(
        cited="Mancl & DeRouen, 2001",
        authors="Mancl, L. A. and DeRouen, T. A.",
        year=2001,
        title="A covariance estimator for GEE with improved small-sample properties",
        journal="Biometrics",
        volume="57",
        pages="126-134",
    ),
    "hautus1995": Reference(
        cited="Hautus, 1995",
        authors="Hautus, M. J.",
        year=1995,
        title="Corrections for extreme proportions and their biasing effects on "
        "estimated values of d'",
        journal="Behavior Research Methods, Instruments, & Computers",
        volume="27",
        pages="46-51",
    ),
    "scipy2020": Reference(
        cited="Virtanen et al., 2020",
        authors="Virtanen, P. and others",
        year=2020,
        title="SciPy 1.0: fundamental algorithms for scientific computing in Python",
        journal="Nature Methods",
        volume="17",
        pages="261-272",
    ),
    "pingouin2018": Reference(
        cited="Vallat, 2018",
        authors="Vallat, R.",
        year=2018,
        title="Pingouin: statistics in Python",
        journal="Journal of Open Source Software",
        volume="3",
        pages="1026",
    ),
    "statsmodels2010": Reference(
        cited="Seabold & Perktold, 2010",
        authors="Seabold, S. and Perktold, J.",
        year=2010,
        title="statsmodels: econometric and statistical modeling with Python",
        journal="Proceedings of the 9th Python in Science Conference",
        volume="",
        pages="92-96",
    ),
}
