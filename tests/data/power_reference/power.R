# The simulated population and the primary tests of slipscale power, written once more in base R.
# Rscript power.R > power.csv   (R 4.2.2; some minutes)
# The model: experiments/participants/simulated_people/population.py. Friedman's test; Wilcoxon's signed-rank test of
# every pair with R's own exact distribution (ties ranked, zeros left out), Holm over the six pairs.
set.seed(2007)
amplitude <- c(0, 0.5, 1.2, 2.3)
mu <- c(12.75, 19.58, 56.25, 81.33) / 100
sigma <- c(12.75, 8.11, 8.82, 10.76) / 100
shared <- 0.55; trial <- 0.15; noise_sigma <- 0.25
own <- 1 - shared - trial

# Who drops out does so after any of the run's trials: four steps before, four for practice, and
# the blocks of main trials, each in random order.
dropped <- function(n, repetitions, dropout) {
  gone <- array(FALSE, c(n, 4, repetitions))
  for (i in which(runif(n) < dropout)) {
    last <- floor(runif(1) * (8 + 4 * repetitions))
    for (r in 1:repetitions) gone[i, sample(4), r] <- 8 + 4 * (r - 1) + 0:3 > last
  }
  gone
}

study <- function(n, repetitions, effect, lapses, dropout = 0, growth = 0) {
  own_mu <- mu
  if (growth > 0) own_mu[-1] <- mu[4] * (amplitude[-1] / amplitude[4])^growth
  m <- mean(own_mu) + effect * (own_mu - mean(own_mu))
  s <- pmin(sigma, 0.9 * sqrt(m * (1 - m)))
  k <- m * (1 - m) / s^2 - 1
  u <- log1p(amplitude / 0.5); u <- (u - u[1]) / (u[4] - u[1])
  angle <- atan2(sqrt(own), sqrt(shared)) * (2 * u - 1)
  a <- rnorm(n); b <- rnorm(n)
  sd <- sqrt(trial) * exp(noise_sigma * rnorm(n) - noise_sigma^2)
  y <- matrix(0, n, 4)
  gone <- if (dropout > 0) dropped(n, repetitions, dropout) else array(FALSE, c(n, 4, repetitions))
  rated <- array(NA, c(n, 4, repetitions))
  for (j in 1:4) {
    person <- sqrt(1 - trial) * (cos(angle[j]) * a + sin(angle[j]) * b)
    for (r in 1:repetitions) {
      z <- person + sd * rnorm(n)
      p <- 100 * qbeta(pnorm(z), m[j] * k[j], (1 - m[j]) * k[j])
      lapse <- runif(n) < lapses
      p[lapse] <- 100 * runif(sum(lapse))
      p[gone[, j, r]] <- NA
      rated[, j, r] <- round(pmin(p, 100))
    }
    y[, j] <- rowMeans(matrix(rated[, j, ], n), na.rm = TRUE)
  }
  y[is.nan(y)] <- NA
  list(means = round(y, 9), rated = rated)
}

signed_rank <- function(d) {
  d <- d[!is.na(d) & d != 0]; n <- length(d)
  if (n == 0) return(1)
  v <- sum(rank(abs(d))[d > 0])
  min(1, 2 * min(psignrank(floor(v), n), psignrank(ceiling(v) - 1, n, lower.tail = FALSE)))
}

exponent <- function(rated) {
  logs <- log(rated)
  logs[!is.finite(logs)] <- NA  # zeros are left out
  logs <- apply(logs, c(1, 2), mean, na.rm = TRUE)
  x <- log(amplitude[-1])
  slopes <- apply(logs[, -1], 1, function(row) {
    ok <- is.finite(row)
    if (sum(ok) < 2) return(NA)
    centred <- x[ok] - mean(x[ok])
    sum(centred * row[ok]) / sum(centred^2)
  })
  slopes <- slopes[!is.na(slopes)]
  qt(0.975, length(slopes) - 1) * sd(slopes) / sqrt(length(slopes))
}

cat("participants,repetitions,effect,lapses,dropout,exponent,studies,friedman,p01,p12,p23,half_width\n")
studies <- 2000
for (case in list(c(8, 1, 1, 0, 0, 0), c(16, 1, 0.5, 0, 0, 0), c(12, 4, 0.3, 0, 0, 0),
                  c(12, 1, 0.4, 0.05, 0, 0), c(10, 1, 0, 0, 0, 0), c(12, 1, 0.5, 0, 0.4, 0),
                  c(12, 2, 0.5, 0.02, 0.3, 0), c(12, 1, 0.5, 0, 0, 0.6))) {
  found <- replicate(studies, {
    one <- study(case[1], case[2], case[3], case[4], case[5], case[6])
    y <- one$means
    pairs <- combn(4, 2)
    p <- p.adjust(apply(pairs, 2, function(ij) signed_rank(y[, ij[2]] - y[, ij[1]])), "holm")
    whole <- y[!is.na(rowSums(y)), , drop = FALSE]
    any <- if (nrow(whole) < 3) 1 else friedman.test(whole)$p.value
    c(any < 0.05, p[1] < 0.05, p[4] < 0.05, p[6] < 0.05, exponent(one$rated))
  })
  cat(paste(c(case, studies, rowSums(found[1:4, ]), mean(found[5, ])), collapse = ","), "\n", sep = "")
}
