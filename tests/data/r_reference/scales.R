# What lme4 says of scales.csv (simulated: 10 participants, 3 repetitions, stimuli in nm, µPa and
# degrees Celsius). Debian: r-base-core r-cran-lme4. Run here: Rscript scales.R > scales.json
suppressPackageStartupMessages(library(lme4))
d <- read.csv("scales.csv")
fit <- function(name) {
  z <- d[d$set == name, ]; z$ly <- log(z$y); z$lx <- log(z$x) - mean(log(z$x))
  m <- lmer(ly ~ lx + (1 + lx | participant), z)
  sprintf('"%s": {"exponent": %.10g, "se": %.10g, "log_likelihood_reml": %.10g, "sd_exponent": %.10g, "sd_residual": %.10g}',
          name, fixef(m)[[2]], sqrt(diag(as.matrix(vcov(m))))[[2]], as.numeric(logLik(m)),
          attr(VarCorr(m)$participant, "stddev")[[2]], sigma(m))
}
cat("{", paste(sapply(c("nm", "micropascal", "degrees"), fit), collapse = ",\n "), "}\n")
