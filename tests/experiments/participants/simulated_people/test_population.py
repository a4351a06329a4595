"""The simulated population: what is kept of it does not grow with what was felt."""

from slipscale.experiments.participants.simulated_people import population


def test_what_is_kept_for_the_next_has_an_end(monkeypatch):
    """An adaptive method presents ever new amplitudes."""
    monkeypatch.setattr(population, "MOST_KEPT", 10)
    known = population.Curves(population.Population())
    felt = [known.mean(number / 1000) for number in range(1000)]
    assert len(known._known) <= 10
    assert felt == sorted(felt)
