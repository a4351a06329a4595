# Writes the tables beside this script, and R's own figures of them: Rscript make.R
# sleepstudy: package lme4 (GPL-2 or later); Belenky et al. (2003), J. Sleep Res. 12, 1-12.
# Orthodont: package nlme (GPL-2 or later); Potthoff and Roy (1964), Biometrika 51, 313-326.
# Orange, CO2: package datasets (part of R, GPL-2 | GPL-3); Draper and Smith (1998), Applied
# Regression Analysis; Potvin, Lechowicz and Tardif (1990), Ecology 71, 1389-1400.
data(sleepstudy, package = "lme4")
data(Orthodont, package = "nlme")
tables <- list(
  sleepstudy = list(sleepstudy, "Subject", "Days", "Reaction"),
  orthodont = list(Orthodont, "Subject", "age", "distance"),
  orange = list(datasets::Orange, "Tree", "age", "circumference"),
  co2 = list(datasets::CO2, "Plant", "conc", "uptake")
)
rows <- NULL
for (name in names(tables)) {
  part <- tables[[name]]
  d <- as.data.frame(part[[1]])
  write.csv(d, paste0(name, ".csv"), row.names = FALSE)
  who <- factor(as.character(d[[part[[2]]]]))
  x <- d[[part[[3]]]]
  y <- d[[part[[4]]]]
  slopes <- sapply(split(data.frame(x, y)[x > 0, ], who[x > 0]),
                   function(s) coef(lm(log(y) ~ log(x), s))[[2]])
  interval <- t.test(slopes)$conf.int
  ranks <- friedman.test(y, factor(x), who)
  wide <- tapply(log(y), list(who, x), mean)
  long <- data.frame(l = c(wide), s = factor(row(wide)), a = factor(col(wide)))
  f <- summary(aov(l ~ a + Error(s / a), long))[["Error: s:a"]][[1]]["a", "F value"]
  rows <- rbind(rows, data.frame(
    table = name, participants = nlevels(who), exponent = mean(slopes), low = interval[1],
    high = interval[2], friedman_chi2 = unname(ranks$statistic), F = f))
}
write.csv(format(rows, digits = 12), "r_figures.csv", row.names = FALSE, quote = FALSE)
