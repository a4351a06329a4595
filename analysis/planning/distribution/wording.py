"""What numbers and conclusions of an analysis are called, for people.

A name that stands in no table is shown as it is: a new result needs no words to be seen.
"""

from __future__ import annotations

import re

#: Conclusion's name -> what it says; in the order in which they are shown.
CONCLUSIONS = {
    r"friedman\.p": "amplitudes differ (Friedman's test)",
    r"rm_anova\.p_gg": "amplitudes differ (repeated-measures ANOVA of logarithms)",
    r"pairwise\.(.+) - (.+)\.p_wilcoxon_holm": "{0} and {1} µm differ (Wilcoxon's test, Holm)",
    r"pairwise\.(.+) - (.+)\.p_holm": "{0} and {1} µm differ (paired t of logarithms, Holm)",
    r"pairwise\.(.+) - (.+)\.equivalence_p_holm": "{0} and {1} µm are equivalent (two one-sided "
    "tests, Holm)",
    r"page_trend\.p": "estimates rise with amplitude (Page's test)",
    r"linear_trend\.p": "log estimates have a linear trend",
    r"growth\.amplitude\.best: (.+)": "of the growth functions, {0} fits best",
    r"growth\.friction\.best: (.+)": "of the functions of relative friction, {0} fits best",
    r"growth\.friction\.exponent\.p": "the exponent against relative friction differs from 0",
    r"order\.position\.p": "estimates drift over a session",
    r"order\.carry_over\.p": "estimates depend on the surface before",
    r"sessions\.anova\.session\.p": "sessions differ (analysis of variance)",
    r"sessions\.anova\.amplitude\.p": "amplitudes differ (analysis of variance with sessions)",
    r"sessions\.anova\.interaction\.p": "sessions differ by amplitude (interaction)",
    r"sessions\.measures\.(.+)\.changes\.(.+)\.p_holm": "{0}: session {1} differs from the first",
    r"ratings\.(.+)\.friedman\.p": "{0}: ratings differ between surfaces (Friedman's test)",
    r"ratings\.(.+)\.page_trend\.p": "{0}: ratings rise with amplitude (Page's test)",
    r"ratings\.(.+)\.pairs\.(.+) - (.+)\.p_wilcoxon_holm": "{0}: {1} and {2} differ "
    "(Wilcoxon's test, Holm)",
    r"productions\.(.+)\.slope\.p": "{0}: produced amplitudes rise with the number",
    r"difference\.finding\.all_felt_a_difference": "everybody felt a difference at least once",
    r"difference\.finding\.all_said_less_slippery": "everybody said “less slippery”",
    r"difference\.psychometric\.p": "“yes” depends on what was removed",
    r"difference\.weber\.p": "“yes” depends on the Weber fraction removed",
    r"matching\.(.+) - (.+)\.bias_um_pp\.p": "{0}, {1} µm: matches differ from the reference",
    r"matching\.(.+) - (.+)\.direction_um_pp\.p": "{0}, {1} µm: the direction of turning matters",
}
#: Number's name -> what it is, of those that are drawn and shown first.
HEADLINES = {
    r"power_law\.exponent": "exponent of the power function",
    r"friedman\.kendalls_w": "Kendall's W",
    r"difference\.d_prime": "d′ of the descending difference",
    r"thresholds\.([^ ]+)(?: - .+)?\.population\.threshold_um_pp\.value": "{0}: threshold, µm p-p",
    r"thresholds\.([^ ]+)(?: - .+)?\.population\.sd": "{0}: SD over people, log10 units",
    r"thresholds\.([^ ]+)(?: - .+)?\.weber_fraction\.value": "{0}: Weber fraction",
    r"ratios\.([^ ]+)(?: - .+)?\.power_law\.exponent": "{0}: exponent",
    r"productions\.([^ ]+)(?: - .+)?\.exponent": "{0}: exponent",
    r"ratings\.(.+)\.surfaces\.(.+)\.mean": "{0}: mean rating of {1}",
    r"matching\.(.+) - (.+)\.bias_um_pp\.mean": "{0}, {1} µm: match less reference, µm p-p",
    r"matching\.(.+) - (.+)\.variability_um_pp": "{0}, {1} µm: a person's SD of matches, µm p-p",
    r"scales\.(.+)\.differences\.values\.(.+)": "{0}: scale value of {1}",
    r"scales\.(.+)\.bradley_terry\.values\.(.+)": "{0}: Bradley-Terry value of {1}",
    r"scales\.(.+)\.thurstone\.values\.(.+)": "{0}: Thurstone value of {1}",
    r"sessions\.measures\.(.+)\.agreement\.value": "{0}: ICC(A,1) between sessions",
}


def said(name: str, table: dict[str, str]) -> tuple[int, str]:
    """Return a name's place in a table and its words; behind all others and itself if unknown.

    >>> said("pairwise.0 - 0.5.p_holm", CONCLUSIONS)[1]
    '0 and 0.5 µm differ (paired t of logarithms, Holm)'
    """
    for place, (pattern, words) in enumerate(table.items()):
        if match := re.fullmatch(pattern, name):
            return place, words.format(*match.groups())
    return len(table), name
