# What R says of estimates.csv (12 participants, 4 amplitudes, 4 repetitions, simulated), for the
# tests to compare with. Debian: r-base-core r-cran-afex r-cran-lmertest r-cran-psych
# r-cran-effectsize r-cran-jsonlite. Run here: Rscript reference.R > reference.json
suppressPackageStartupMessages({library(afex); library(lme4); library(lmerTest); library(psych); library(effectsize); library(jsonlite)})
d <- read.csv("estimates.csv"); d$ly <- log(d$est); d$a <- factor(d$amp)
g <- aggregate(ly ~ participant + a, d, mean)
w <- reshape(g, idvar = "participant", timevar = "a", direction = "wide")
y <- as.matrix(w[, -1])

m <- aov_ez("participant", "ly", g, within = "a")
s <- summary(m)
adj <- s$pval.adjustments
ges <- anova(m, es = "ges", correction = "none")
f <- friedman.test(y)
holm <- pairwise.t.test(g$ly[order(g$a, g$participant)], sort(g$a), paired = TRUE, p.adjust = "holm")
wil <- function(i, j) wilcox.test(y[, i], y[, j], paired = TRUE, exact = TRUE)$p.value
dz <- function(i, j) unlist(cohens_d(y[, j], y[, i], paired = TRUE)[c("Cohens_d", "CI_low", "CI_high")], use.names = FALSE)

x <- subset(d, amp > 0); x$lx <- log(x$amp)
m2 <- lmer(ly ~ lx + (1 + lx | participant), x)
slopes <- sapply(split(x, x$participant), function(z) coef(lm(ly ~ lx, z))[[2]])
t <- t.test(slopes)

p <- afex_plot(m, x = "a", error = "within", return = "data")$means
r <- reshape(d[, c("participant", "amp", "rep", "ly")], idvar = c("participant", "amp"),
             timevar = "rep", direction = "wide")
icc <- ICC(r[, 3:6], lmer = FALSE)$results

# Linear trend at the true distances of the amplitudes: one contrast a participant, then t.
k <- c(0, .5, 1.2, 2.3); k <- k - mean(k)
trend <- t.test(as.vector(y %*% (k / sum(k^2))))

out <- list(
  versions = list(R = as.character(getRversion()), afex = as.character(packageVersion("afex")),
                  lme4 = as.character(packageVersion("lme4")),
                  psych = as.character(packageVersion("psych")),
                  effectsize = as.character(packageVersion("effectsize"))),
  anova = list(F = s$univariate.tests["a", "F value"], df1 = s$univariate.tests["a", "num Df"],
               df2 = s$univariate.tests["a", "den Df"], p = s$univariate.tests["a", "Pr(>F)"],
               eta2_generalised = ges["a", "ges"],
               mauchly_w = s$sphericity.tests["a", "Test statistic"],
               mauchly_p = s$sphericity.tests["a", "p-value"],
               epsilon_gg = adj["a", "GG eps"], p_gg = adj["a", "Pr(>F[GG])"],
               epsilon_hf = adj["a", "HF eps"], p_hf = adj["a", "Pr(>F[HF])"]),
  friedman = list(chi2 = unname(f$statistic), df = unname(f$parameter), p = f$p.value),
  pairwise_t_holm = holm$p.value[lower.tri(holm$p.value, diag = TRUE)],
  wilcoxon_exact = c(wil(1, 2), wil(1, 3), wil(1, 4), wil(2, 3), wil(2, 4), wil(3, 4)),
  d_z = list(dz(1, 2), dz(1, 3), dz(1, 4), dz(2, 3), dz(2, 4), dz(3, 4)),
  exponent = list(mean = unname(t$estimate), ci95 = as.vector(t$conf.int), se = t$stderr),
  mixed = list(intercept = fixef(m2)[[1]], slope = fixef(m2)[[2]],
               se = unname(sqrt(diag(as.matrix(vcov(m2))))), loglik_reml = as.numeric(logLik(m2)),
               residual_sd = sigma(m2)),
  trend = list(slope = unname(trend$estimate), t = unname(trend$statistic), p = trend$p.value,
               ci95 = as.vector(trend$conf.int)),
  cousineau_morey_half_widths = p$y - p$lower,
  icc = setNames(as.list(icc$ICC), icc$type),
  clopper_pearson_17_of_20 = as.vector(binom.test(17, 20)$conf.int))
cat(toJSON(out, auto_unbox = TRUE, digits = 12, pretty = TRUE), "\n")
