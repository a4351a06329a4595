# Scales of paired comparisons with Firth's correction, by base R's own optimiser.
# Rscript firth.R > firth.json      (in this folder; needs jsonlite)
library(jsonlite)

# Maximise log likelihood + half the log determinant of the information; the first value is 0.
scale <- function(won, p, density) {
  k <- nrow(won)
  pairs <- t(combn(k, 2))
  x <- matrix(0, nrow(pairs), k)
  x[cbind(seq_len(nrow(pairs)), pairs[, 1])] <- 1
  x[cbind(seq_len(nrow(pairs)), pairs[, 2])] <- -1
  x <- x[, -1, drop = FALSE]
  yes <- won[pairs]; no <- won[pairs[, 2:1, drop = FALSE]]
  minus <- function(b) {
    z <- drop(x %*% b); q <- p(-z); q1 <- p(z)
    w <- (yes + no) * density(z)^2 / (q * q1)
    -sum(yes * log(q1) + no * log(q)) - determinant(crossprod(x, w * x))$modulus / 2
  }
  found <- list(par = rep(0, k - 1))
  for (again in 1:3) {
    found <- optim(found$par, minus, method = "BFGS",
                   control = list(reltol = 1e-16, maxit = 1e4, ndeps = rep(1e-6, k - 1)))
  }
  values <- c(0, found$par)
  values - mean(values)
}
both <- function(won) list(won = won, bradley_terry = scale(won, plogis, dlogis),
                           thurstone = scale(won, pnorm, dnorm))

# Citations between four journals (Stigler 1994); a surface that was never chosen; one pair, all or
# nothing.
cat(toJSON(list(
  journals = both(rbind(c(0, 730, 498, 221), c(33, 0, 68, 17), c(320, 813, 0, 142),
                        c(284, 276, 325, 0))),
  never_chosen = both(rbind(c(0, 9, 9), c(0, 0, 4), c(0, 5, 0))),
  one_pair = both(rbind(c(0, 5), c(0, 0)))
), digits = 10, auto_unbox = TRUE, pretty = TRUE), "\n")
