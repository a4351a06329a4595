# The simulated population and the primary tests of slipscale power, written once more in base R.
# Rscript power.R > power.csv   (R 4.2.2; some minutes)
# The model: experiments/participants/population.py. Friedman's test; Wilcoxon's signed-rank test of
# every pair with R's own exact distribution (ties ranked, zeros left out), Holm over the six pairs.
set.seed(2007)
amplitude <- c(0, 0.5, 1.2, 2.3)
mu <- c(12.75, 19.58, 56.25, 81.33) / 100
sigma <- c(12.75, 8.11, 8.82, 10.76) / 100
shared <- 0.55; trial <- 0.15; noise_sigma <- 0.25
own <- 1 - shared - trial

study <- function(n, repetitions, effect, lapses) {
  m <- mean(mu) + effect * (mu - mean(mu))
  s <- pmin(sigma, 0.9 * sqrt(m * (1 - m)))
  k <- m * (1 - m) / s^2 - 1
  u <- log1p(amplitude / 0.5); u <- (u - u[1]) / (u[4] - u[1])
  angle <- atan2(sqrt(own), sqrt(shared)) * (2 * u - 1)
  a <- rnorm(n); b <- rnorm(n)
  sd <- sqrt(trial) * exp(noise_sigma * rnorm(n) - noise_sigma^2)
  y <- matrix(0, n, 4)
  for (j in 1:4) {
    person <- sqrt(1 - trial) * (cos(angle[j]) * a + sin(angle[j]) * b)
    for (r in 1:repetitions) {
      z <- person + sd * rnorm(n)
      p <- 100 * qbeta(pnorm(z), m[j] * k[j], (1 - m[j]) * k[j])
      lapse <- runif(n) < lapses
      p[lapse] <- 100 * runif(sum(lapse))
      y[, j] <- y[, j] + round(pmin(p, 100)) / repetitions
    }
  }
  round(y, 9)
}

signed_rank <- function(d) {
  d <- d[d != 0]; n <- length(d)
  if (n == 0) return(1)
  v <- sum(rank(abs(d))[d > 0])
  min(1, 2 * min(psignrank(floor(v), n), psignrank(ceiling(v) - 1, n, lower.tail = FALSE)))
}

exponent <- function(y) {
  x <- log(amplitude[-1]); x <- x - mean(x)
  slopes <- apply(y[, -1], 1, function(row) if (all(row > 0)) sum(x * log(row)) / sum(x^2) else NA)
  slopes <- slopes[!is.na(slopes)]
  qt(0.975, length(slopes) - 1) * sd(slopes) / sqrt(length(slopes))
}

cat("participants,repetitions,effect,lapses,studies,friedman,p01,p12,p23,half_width\n")
studies <- 2000
for (case in list(c(8, 1, 1, 0), c(16, 1, 0.5, 0), c(12, 4, 0.3, 0), c(12, 1, 0.4, 0.05),
                  c(10, 1, 0, 0))) {
  found <- replicate(studies, {
    y <- study(case[1], case[2], case[3], case[4])
    pairs <- combn(4, 2)
    p <- p.adjust(apply(pairs, 2, function(ij) signed_rank(y[, ij[2]] - y[, ij[1]])), "holm")
    c(friedman.test(y)$p.value < 0.05, p[1] < 0.05, p[4] < 0.05, p[6] < 0.05, exponent(y))
  })
  cat(paste(c(case, studies, rowSums(found[1:4, ]), mean(found[5, ])), collapse = ","), "\n", sep = "")
}
