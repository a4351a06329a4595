# Equivalence, groups and growth functions, by base R.
# Rscript comparisons.R > comparisons.json      (in this folder; needs jsonlite)
library(jsonlite)
d <- read.csv("estimates.csv")
d$ly <- log(d$est)
g <- aggregate(ly ~ participant + amp, d, mean)
y <- sapply(sort(unique(g$amp)), function(a) { z <- g[g$amp == a, ]; z$ly[order(z$participant)] })

# Two one-sided paired t tests within a ratio of 2.5, and the interval at 90 % that decides.
tost <- function(i, j, bound = log(2.5)) {
  above <- t.test(y[, j], y[, i], paired = TRUE, mu = -bound, alternative = "greater")$p.value
  below <- t.test(y[, j], y[, i], paired = TRUE, mu = bound, alternative = "less")$p.value
  ci <- exp(t.test(y[, j], y[, i], paired = TRUE, conf.level = .9)$conf.int)
  list(p = max(above, below), ci = as.vector(ci))
}
pairs <- list(c(1, 2), c(1, 3), c(1, 4), c(2, 3), c(2, 4), c(3, 4))
same <- lapply(pairs, function(p) tost(p[1], p[2]))

# Two groups: Orthodont, boys and girls; log distance on log age.
o <- read.csv("../foreign/orthodont.csv")
o$ly <- log(o$distance)
slope <- sapply(split(o, o$Subject), function(z) coef(lm(ly ~ log(age), z))[[2]])
level <- sapply(split(o, o$Subject), function(z) mean(z$ly))
sex <- sapply(split(o, o$Subject), function(z) as.character(z$Sex[1]))
welch <- function(v) {
  t <- t.test(v ~ sex)
  list(t = unname(t$statistic), df = unname(t$parameter), p = t$p.value,
       difference = unname(t$estimate[1] - t$estimate[2]), ci = as.vector(t$conf.int))
}
o$f <- factor(o$age)
s <- summary(aov(ly ~ Sex * f + Error(Subject), o))
between <- s[["Error: Subject"]][[1]]
within <- s[["Error: Within"]][[1]]
w <- reshape(o[, c("Subject", "age", "ly")], idvar = "Subject", timevar = "age", direction = "wide")
e <- SSD(lm(as.matrix(w[, -1]) ~ sex[as.character(w$Subject)]))$SSD
k <- ncol(e)
ce <- (diag(k) - 1 / k) %*% e %*% (diag(k) - 1 / k)
eps <- sum(diag(ce))^2 / ((k - 1) * sum(ce^2))

# Three groups of one variable: the trees' circumference would do; here thirds of the boys and girls.
third <- factor(rep(c("a", "b", "c"), length.out = length(slope)))
o3 <- oneway.test(slope ~ third)

# Growth functions: least squares on mean logarithms by R's own optimiser, each participant with an
# own constant; Ekman's of the estimates above 0, Naka and Rushton's of CO2's uptake, which saturates.
growth <- function(x, l, shape, starts) {
  l <- l - rowMeans(l)
  rss <- function(t) { s <- shape(x, exp(t)); sum(sweep(l, 2, s - mean(s))^2) }
  best <- NULL
  for (a in c(-.5, 0, .7)) for (b in starts) {
    o <- optim(c(a, b), rss, control = list(reltol = 1e-14, maxit = 5000))
    if (is.null(best) || o$value < best$value) best <- o
  }
  n <- length(l); k <- 2 + nrow(l) + 1
  ll <- -n / 2 * (log(2 * pi * best$value / n) + 1)
  list(exponent = exp(best$par[1]), stimulus = exp(best$par[2]), log_likelihood = ll,
       aicc = 2 * k - 2 * ll + 2 * k * (k + 1) / (n - k - 1))
}
u <- read.csv("../foreign/co2.csv")
fits <- list(
  ekman = growth(sort(unique(g$amp))[-1], y[, -1], function(x, t) log(1 + (x / t[2])^t[1]), -1:1),
  naka_rushton = growth(sort(unique(u$conc)), log(tapply(u$uptake, list(u$Plant, u$conc), mean)),
                        function(x, t) log(x^t[1] / (x^t[1] + t[2]^t[1])), 4:6))

cat(toJSON(list(
  versions = list(R = as.character(getRversion())),
  growth = fits,
  tost = same,
  tost_holm = p.adjust(sapply(same, function(z) z$p), "holm"),
  orthodont = list(
    exponent = welch(slope), level = welch(level),
    group = list(F = between["Sex", "F value"], df1 = between["Sex", "Df"],
                 df2 = between["Residuals", "Df"], p = between["Sex", "Pr(>F)"]),
    interaction = list(F = within[grep(":", rownames(within)), "F value"],
                       df1 = within[grep(":", rownames(within)), "Df"],
                       df2 = within["Residuals", "Df"], epsilon_gg = eps),
    thirds = list(F = unname(o3$statistic), df1 = unname(o3$parameter[1]),
                  df2 = unname(o3$parameter[2]), p = o3$p.value))
), auto_unbox = TRUE, digits = 12, pretty = TRUE), "\n")
