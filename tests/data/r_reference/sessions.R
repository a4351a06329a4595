# The four repetitions of estimates.csv taken as four sessions, by base R alone.
# Rscript sessions.R > sessions.json      (in this folder)
d <- read.csv("estimates.csv")
d$ly <- log(d$est)
sessions <- sort(unique(d$rep)); amplitudes <- sort(unique(d$amp)); people <- sort(unique(d$participant))
idata <- expand.grid(a = factor(amplitudes), s = factor(sessions))
y <- t(sapply(people, function(p) apply(idata, 1, function(i)
  d$ly[d$participant == p & d$amp == as.numeric(i["a"]) & d$rep == as.numeric(i["s"])])))
# Epsilon to all digits: Box's formula from the covariance of orthonormal contrasts.
epsilon <- function(contrasts) {
  s <- t(contrasts) %*% cov(y) %*% contrasts
  sum(diag(s))^2 / (ncol(contrasts) * sum(s^2))
}
orthonormal <- function(k) { c <- contr.helmert(k); sweep(c, 2, sqrt(colSums(c^2)), "/") }
na <- length(amplitudes); ns <- length(sessions)
cs <- kronecker(orthonormal(ns), matrix(1 / sqrt(na), na)); ca <- kronecker(matrix(1 / sqrt(ns), ns), orthonormal(na))
csa <- kronecker(orthonormal(ns), orthonormal(na))
long <- data.frame(y = as.vector(t(y)), p = factor(rep(people, each = na * ns)),
                   a = rep(idata$a, length(people)), s = rep(idata$s, length(people)))
av <- summary(aov(y ~ s * a + Error(p / (s * a)), long))
row <- function(stratum, contrasts) {
  t <- av[[stratum]][[1]]; f <- t[1, "F value"]; e <- epsilon(contrasts); df <- t[, "Df"]
  list(F = f, df1 = df[1] * e, df2 = df[2] * e, epsilon_gg = e,
       p = pf(f, df[1] * e, df[2] * e, lower.tail = FALSE))
}
# ICC(A,1), McGraw and Wong 1996, tables 4 and 7.
icc <- function(m, level = 0.95) {
  n <- nrow(m); k <- ncol(m); g <- mean(m)
  msr <- k * sum((rowMeans(m) - g)^2) / (n - 1); msc <- n * sum((colMeans(m) - g)^2) / (k - 1)
  mse <- sum((m - outer(rowMeans(m), colMeans(m), "+") + g)^2) / ((n - 1) * (k - 1))
  r <- (msr - mse) / (msr + (k - 1) * mse + k / n * (msc - mse))
  a <- k * r / (n * (1 - r)); b <- 1 + k * r * (n - 1) / (n * (1 - r))
  v <- (a * msc + b * mse)^2 / ((a * msc)^2 / (k - 1) + (b * mse)^2 / ((n - 1) * (k - 1)))
  q <- 1 - (1 - level) / 2; fl <- qf(q, n - 1, v); fu <- qf(q, v, n - 1)
  low <- n * (msr - fl * mse) / (fl * (k * msc + (k * n - k - n) * mse) + n * msr)
  high <- n * (fu * msr - mse) / (k * msc + (k * n - k - n) * mse + n * fu * msr)
  list(value = r, low = low, high = high)
}
by <- function(f) t(sapply(people, function(p) sapply(sessions, function(s) f(d[d$participant == p & d$rep == s, ]))))
level <- by(function(z) mean(z$ly))
slope <- by(function(z) { z <- z[z$amp > 0, ]; coef(lm(ly ~ log(amp), z))[[2]] })
change <- function(m) lapply(2:ns, function(s) { t <- t.test(m[, s] - m[, 1])
  list(mean = unname(t$estimate), t = unname(t$statistic), p = t$p.value, low = t$conf.int[1], high = t$conf.int[2]) })
json <- function(x) if (is.list(x)) if (is.null(names(x))) paste0("[", paste(sapply(x, json), collapse = ", "), "]") else
  paste0("{", paste(sprintf('"%s": %s', names(x), sapply(x, json)), collapse = ", "), "}") else
  if (length(x) > 1) paste0("[", paste(sprintf("%.15g", x), collapse = ", "), "]") else sprintf("%.15g", x)
cat(json(list(session = row(2, cs), amplitude = row(3, ca), interaction = row(4, csa),
  level = list(icc = icc(level), means = colMeans(level), changes = change(level)),
  exponent = list(icc = icc(slope), means = colMeans(slope), changes = change(slope)))), "\n")
