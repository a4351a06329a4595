# A hierarchical psychometric function without guesses and lapses, by lme4 and 25 quadrature points.
# Rscript psychometric.R > psychometric.json      (in this folder; needs jsonlite and lme4)
suppressPackageStartupMessages({library(jsonlite); library(lme4)})
set.seed(3)
d <- expand.grid(level = c(0.8, 0.95, 1.1, 1.25, 1.4, 1.55), person = 1:10)
d$group <- ifelse(d$person <= 5, "a", "b")
own <- rnorm(10, 1.2, 0.08) + 0.1 * (unique(d[c("person", "group")])$group == "b")
d$n <- 15
d$yes <- rbinom(nrow(d), d$n, plogis(12 * (d$level - own[d$person])))
fit <- function(formula) glmer(formula, d, binomial, nAGQ = 25)
one <- fit(cbind(yes, n - yes) ~ level + (1 | person))
two <- fit(cbind(yes, n - yes) ~ level + group + (1 | person))
b <- fixef(one); g <- fixef(two)
cat(toJSON(list(
  data = d,
  equality = -b[[1]] / b[[2]], slope = b[[2]],
  sd = sqrt(VarCorr(one)$person[1]) / b[[2]],
  persons = -(b[[1]] + ranef(one)$person[, 1]) / b[[2]],
  log_likelihood_ratio_of_group = as.numeric(logLik(two) - logLik(one)),
  group_change = -g[[3]] / g[[2]]
), digits = 10, auto_unbox = TRUE), "\n")
