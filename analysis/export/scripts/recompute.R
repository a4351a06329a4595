# Recompute the numbers of a Slipscale report from the files in this folder: Rscript recompute.R
# The script requires only R; the mixed model uses lme4 or, if it is not installed, nlme, which is part
# of R. Every number is recomputed from the trials and settings.csv, and printed next to the number in
# numbers.csv. If recompute_tasks.R is in the same folder, it recomputes all tasks except magnitude
# estimation and the descending difference. The exit status is 1 if a number differs.

close_enough <- 1e-5 # relative tolerance; for iterative fits, the next value applies
close_fits <- 1e-2
# If participants do not differ, an optimiser stops anywhere near 0.
barely <- 0.1 # SD of thresholds relative to the curve's width, below which the likelihood is flat
almost_none <- 5e-3 # SD between participants relative to the residual SD
fitted <- "^(mixed_model|reliability|growth|difference\\.(psychometric|weber)|difference\\.signal_detection\\.(by|all))"
# Integrals on grids, fits of curves, and results computed from them.
on_grids <- "^(thresholds|exponent_and_weber)\\..*(function|maximum_likelihood|weber|population|expected_exponent|ekman)|^similarity\\..*stress|^factors\\..*mixed"
close_grids <- 4e-2
same_maximum <- 1e-3 # difference between log likelihoods
at_its_bound <- "an estimated variance or correlation is on the boundary of its range"

words <- c("participant_id", "session", "run", "flags", "name", "task", "surface", "group", "measure",
           "method", "stimulus1", "stimulus2", "stimulus3", "direction", "began", "bound", "first", "second")
read <- function(name) {
  if (!file.exists(name)) return(NULL)
  there <- intersect(words, names(read.csv(name, nrows = 1, check.names = FALSE)))
  rows <- read.csv(name, na.strings = "", check.names = FALSE, encoding = "UTF-8",
                   colClasses = setNames(rep("character", length(there)), there))
  logical <- vapply(rows, function(column) is.character(column) && all(column %in% c("True", "False", NA)), NA)
  rows[logical] <- lapply(rows[logical], as.logical)
  rows
}
under <- function(prefix, values) if (length(values)) setNames(values, paste0(prefix, names(values)))

mean_test <- function(x, confidence, possible = c(-Inf, Inf)) {
  x <- x[is.finite(x)]
  if (length(x) < 3 || diff(range(x)) <= 1e-12 * max(abs(x), 1)) return(NULL)
  t <- t.test(x, conf.level = confidence)
  c(mean = mean(x), ci.0 = max(t$conf.int[1], possible[1]), ci.1 = min(t$conf.int[2], possible[2]), sd = sd(x),
    t = unname(t$statistic), df = length(x) - 1, p = t$p.value)
}
student <- function(b, se, df, n, confidence) {
  half <- qt((1 + confidence) / 2, df) * se
  c(mean = b, ci.0 = b - half, ci.1 = b + half, sd = se * sqrt(n), t = b / se, df = df,
    p = 2 * pt(-abs(b / se), df))
}
whole_rows <- function(m) m[complete.cases(m), , drop = FALSE]

descriptives <- function(cells, logs, confidence, sample, most) {
  out <- NULL
  within <- which(colSums(is.na(logs)) == 0)
  if (length(within) < 2) within <- which(colSums(!is.na(logs)) > 0)
  w <- whole_rows(logs[, within, drop = FALSE])
  n <- nrow(w)
  k <- ncol(w)
  half <- rep(NA, ncol(logs))
  if (n >= 3 && k >= 2) {
    shifted <- w - rowMeans(w) + mean(w)
    half[within] <- apply(shifted, 2, sd) * sqrt(k / (k - 1)) / sqrt(n) * qt((1 + confidence) / 2, n - 1)
  }
  for (i in seq_len(ncol(cells))) {
    x <- cells[!is.na(cells[, i]), i]
    y <- logs[!is.na(logs[, i]), i]
    far <- max(abs(x - mean(x)))
    population <- sqrt(mean((x - mean(x))^2))
    ends <- function(v) mean(v) + c(-1, 1) * qt((1 + confidence) / 2, length(v) - 1) * sd(v) / sqrt(length(v))
    enough <- function(v) length(v) >= 3 && sd(v) > 1e-12 * max(abs(mean(v)), 1) * sqrt(length(v))
    m <- if (enough(x)) ends(x) else c(NA, NA)
    g <- if (enough(y)) exp(ends(y)) else c(NA, NA)
    out <- c(out, under(paste0("table3.", i - 1, "."), c(
      n = length(x), mean = mean(x), maximum_deviation = far,
      standard_deviation = if (sample) sd(x) else population)),
      under(paste0("descriptives.", i - 1, "."), c(
        n = length(x), mean = mean(x), maximum_deviation = far, sd_sample = sd(x),
        sd_population = population, median = median(x), geometric_n = length(y),
        geometric_mean = exp(mean(y)), mean_low = max(m[1], 0), mean_high = min(m[2], most), geometric_low = g[1],
        geometric_high = min(g[2], most), within_low = exp(mean(y) - half[i]), within_high = min(exp(mean(y) + half[i]), most))))
  }
  out
}

eta_squared <- function(v, confidence) {
  ratio <- function(v) nrow(v) * sum((colMeans(v) - mean(v))^2) / sum((v - mean(v))^2)
  n <- nrow(v)
  each <- sapply(seq_len(n), function(i) ratio(v[-i, , drop = FALSE]))
  pseudo <- n * atanh(sqrt(ratio(v))) - (n - 1) * atanh(sqrt(each))
  ends <- mean(pseudo) + c(-1, 1) * qt((1 + confidence) / 2, n - 1) * sd(pseudo) / sqrt(n)
  ends <- tanh(pmax(ends, 0))^2
  c(eta2_generalised = ratio(v), eta2_generalised_ci.0 = ends[1], eta2_generalised_ci.1 = ends[2])
}

rm_anova <- function(logs, confidence) {
  v <- whole_rows(logs[, colSums(!is.na(logs)) > 0, drop = FALSE])
  n <- nrow(v)
  k <- ncol(v)
  if (n < 3 || k < 2) return(NULL)
  residuals <- v - rowMeans(v)
  residuals <- sweep(residuals, 2, colMeans(residuals))
  df1 <- k - 1
  df2 <- df1 * (n - 1)
  f <- n * sum((colMeans(v) - mean(v))^2) / df1 / (sum(residuals^2) / df2)
  s <- cov(v %*% contr.helmert(k) %*% diag(1 / sqrt(colSums(contr.helmert(k)^2)), df1))
  gg <- sum(diag(s))^2 / (df1 * sum(s^2))
  hf <- if (k > 2) min((n * df1 * gg - 2) / (df1 * (n - 1 - df1 * gg)), 1) else 1
  p <- function(e) pf(f, df1 * e, df2 * e, lower.tail = FALSE)
  out <- c(F = f, df1 = df1, df2 = df2, p = p(1), epsilon_gg = gg, p_gg = p(gg), epsilon_hf = hf,
           p_hf = p(hf), n = n, n_incomplete = nrow(logs) - n, eta_squared(v, confidence))
  if (k > 2 && n >= k) {
    sphericity <- mauchly.test(lm(v ~ 1), X = ~1)
    out <- c(out, mauchly_w = unname(sphericity$statistic), mauchly_p = sphericity$p.value)
  }
  if (length(residuals) <= 5000) {
    normal <- shapiro.test(residuals)
    out <- c(out, shapiro_w = unname(normal$statistic), shapiro_p = normal$p.value)
  }
  out
}

friedman <- function(cells) {
  v <- whole_rows(cells)
  if (nrow(v) < 3 || ncol(v) < 3) return(NULL)
  t <- friedman.test(unname(v))
  chi2 <- unname(t$statistic)
  c(chi2 = chi2, df = ncol(v) - 1, p = t$p.value, kendalls_w = chi2 / (nrow(v) * (ncol(v) - 1)),
    n = nrow(v), n_incomplete = nrow(cells) - nrow(v))
}

convolve_counts <- function(a, b) {
  out <- numeric(length(a) + length(b) - 1)
  for (i in which(b != 0)) out[i - 1 + seq_along(a)] <- out[i - 1 + seq_along(a)] + a * b[i]
  out
}
orders <- function(k) {
  if (k == 1) return(matrix(1))
  shorter <- orders(k - 1)
  do.call(rbind, lapply(seq_len(k), function(i) cbind(i, ifelse(shorter >= i, shorter + 1, shorter))))
}
page_trend <- function(cells) {
  v <- whole_rows(cells)
  n <- nrow(v)
  k <- ncol(v)
  if (n < 3 || k < 3) return(NULL)
  ell <- sum(t(apply(v, 1, rank)) %*% seq_len(k))
  # Exact for the sizes in Page's own tables, for which the computation takes no time.
  if (k <= 8 && n <= 20 && (n <= 12 || k <= 3)) {
    one <- tabulate(orders(k) %*% seq_len(k) + 1)
    total <- 1
    for (i in seq_len(n)) total <- convolve_counts(total, one / sum(one))
    p <- sum(total[(floor(ell) + 1):length(total)])
  } else {
    p <- pnorm((ell - n * k * (k + 1)^2 / 4) / sqrt(n * (k^3 - k)^2 / (144 * (k - 1))), lower.tail = FALSE)
  }
  c(L = ell, p = p, n = n, n_incomplete = nrow(cells) - n)
}

signed_rank <- function(steps) {
  if (!any(steps != 0)) return(NA)
  # Equal means can differ in the last bits, by the order of addition.
  steps <- round(steps / max(abs(steps)), 9)
  steps <- steps[steps != 0]
  ranks <- rank(abs(steps))
  tied <- anyDuplicated(ranks) > 0
  if ((tied && length(steps) <= 13) || (!tied && length(steps) <= 50)) {
    # All patterns of signs are equally likely. Sums of doubled ranks are computed by convolution.
    counts <- 1
    for (r in round(2 * ranks)) counts <- convolve_counts(counts, c(0.5, rep(0, r - 1), 0.5))
    up <- round(2 * sum(ranks[steps > 0]))
    return(min(1, 2 * min(sum(counts[seq_len(up + 1)]), sum(counts[(up + 1):length(counts)]))))
  }
  wilcox.test(steps, exact = FALSE, correct = FALSE)$p.value
}

noncentrality <- function(t, df, p) {
  y <- qchisq(c(1e-14, 1 - 1e-14), df)
  below <- function(shift) integrate(function(v) pnorm(t * sqrt(v / df) - shift) * dchisq(v, df),
                                     y[1], y[2], rel.tol = 1e-11, subdivisions = 1000)$value - p
  width <- 10 + 3 * abs(t)
  uniroot(below, c(t - width, t + width), tol = 1e-11)$root
}

bayes_factor <- function(t, n, scale = 0.707) {
  log_of <- function(u) {
    a <- 1 + n * exp(u) * scale^2
    -log(a) / 2 - n / 2 * log(1 + t^2 / (a * (n - 1))) + n / 2 * log(1 + t^2 / (n - 1)) -
      (u + log(2 * pi) + exp(-u)) / 2
  }
  grid <- seq(-30, 30, length.out = 601)
  peak <- grid[which.max(log_of(grid))]
  top <- max(log_of(grid))
  part <- function(a, b) integrate(function(u) exp(log_of(u) - top), a, b, rel.tol = 1e-10, subdivisions = 1000)$value
  exp(top) * (part(peak - 30, peak) + part(peak, peak + 60))
}

pairwise <- function(cells, logs, confidence, bound) {
  rows <- list()
  for (pair in asplit(combn(ncol(cells), 2), 2)) {
    d <- logs[, pair[2]] - logs[, pair[1]]
    d <- d[!is.na(d)]
    s <- cells[, pair[2]] - cells[, pair[1]]
    s <- s[!is.na(s)]
    row <- c(n = length(s), n_logs = length(d), up = sum(s > 0), down = sum(s < 0),
             p_wilcoxon = if (length(s) >= 3) signed_rank(s) else NA)
    m <- mean_test(d, confidence)
    if (!is.null(m)) {
      n <- length(d)
      t <- m[["t"]]
      df <- n - 1
      se <- m[["sd"]] / sqrt(n)
      half <- qt(confidence, df) * se
      row <- c(row, ratio = exp(m[["mean"]]), ratio_ci.0 = exp(m[["ci.0"]]), ratio_ci.1 = exp(m[["ci.1"]]),
               t = t, df = df, p = m[["p"]], d_z = m[["mean"]] / m[["sd"]],
               d_z_ci.0 = noncentrality(t, df, (1 + confidence) / 2) / sqrt(n),
               d_z_ci.1 = noncentrality(t, df, (1 - confidence) / 2) / sqrt(n),
               equivalence_ratio = bound, equivalence_ci.0 = exp(m[["mean"]] - half),
               equivalence_ci.1 = exp(m[["mean"]] + half),
               equivalence_p = pt(min(log(bound) + m[["mean"]], log(bound) - m[["mean"]]) / se, df, lower.tail = FALSE),
               bayes_factor_10 = bayes_factor(t, n))
    }
    rows[[length(rows) + 1]] <- row
  }
  for (name in c("p", "p_wilcoxon", "equivalence_p")) {
    p <- sapply(rows, function(row) if (name %in% names(row)) row[[name]] else NA)
    # Tests that are not defined are not counted.
    p[!is.na(p)] <- p.adjust(p[!is.na(p)], "holm")
    for (i in seq_along(rows)) rows[[i]][[paste0(name, "_holm")]] <- p[i]
  }
  unlist(lapply(seq_along(rows), function(i) under(paste0("pairwise.", i - 1, "."), rows[[i]])))
}

slopes <- function(logs, levels) {
  above <- levels > 0
  apply(logs[, above, drop = FALSE], 1, function(y) {
    if (sum(!is.na(y)) > 1) coef(lm(y ~ log(levels[above])))[[2]] else NA
  })
}
power_law <- function(logs, levels, confidence) {
  m <- mean_test(slopes(logs, levels), confidence)
  if (is.null(m)) return(NULL)
  c(exponent = m[["mean"]], m[c("ci.0", "ci.1", "sd")], n = m[["df"]] + 1,
    points = max(rowSums(!is.na(logs[, levels > 0, drop = FALSE]))))
}
# Theil-Sen slopes of trials, and Tukey and McLaughlin's interval for their 20 % trimmed mean.
robust_exponent <- function(trials, confidence) {
  d <- trials[trials$level > 0 & !is.na(trials$log), ]
  x <- sort(unlist(lapply(split(d, d$who, drop = TRUE), function(p) {
    if (length(unique(p$level)) < 2) return(NULL)
    pairs <- combn(nrow(p), 2)
    dx <- log(p$level[pairs[2, ]] / p$level[pairs[1, ]])
    median(((p$log[pairs[2, ]] - p$log[pairs[1, ]]) / dx)[p$level[pairs[2, ]] != p$level[pairs[1, ]]])
  })))
  n <- length(x)
  if (n < 3 || diff(range(x)) == 0) return(NULL)
  cut <- floor(0.2 * n)
  kept <- n - 2 * cut
  w <- pmin(pmax(x, x[cut + 1]), x[n - cut])
  half <- qt((1 + confidence) / 2, kept - 1) * sqrt((n - 1) * var(w) / kept / (kept - 1))
  exponent <- mean(x, trim = 0.2)
  c(exponent = exponent, ci.0 = exponent - half, ci.1 = exponent + half, n = n, trimmed = 2 * cut)
}
linear_trend <- function(logs, levels, confidence) {
  some <- colSums(!is.na(logs)) > 0
  w <- whole_rows(logs[, some, drop = FALSE])
  x <- levels[some] - mean(levels[some])
  if (nrow(w) < 3 || ncol(w) < 2) return(NULL)
  m <- mean_test(as.vector(w %*% x) / sum(x^2), confidence)
  if (!is.null(m)) c(m, n = nrow(w), n_incomplete = nrow(logs) - nrow(w))
}

mixed_model <- function(trials, confidence) {
  d <- trials[trials$level > 0 & !is.na(trials$log), ]
  centre <- mean(log(d$level))
  d$lx <- log(d$level) - centre
  if (requireNamespace("lme4", quietly = TRUE)) {
    m <- suppressMessages(suppressWarnings(lme4::lmer(log ~ lx + (1 + lx | who), d)))
    b <- lme4::fixef(m)
    se <- sqrt(diag(as.matrix(vcov(m))))[[2]]
    if (lme4::isSingular(m, tol = 1e-2)) cat("mixed model:", at_its_bound, "\n")
    g <- as.matrix(lme4::VarCorr(m)$who)
    residual <- sigma(m)
  } else {
    # At a bound, nlme stops with an error, whereas lme4 continues.
    m <- tryCatch(nlme::lme(log ~ lx, d, ~ lx | who, control = nlme::lmeControl(opt = "optim")),
                  error = function(e) NULL)
    if (is.null(m)) return(NULL)
    b <- nlme::fixef(m)
    se <- sqrt(diag(vcov(m)))[[2]]
    g <- as.matrix(nlme::getVarCov(m))
    residual <- m$sigma
  }
  n <- length(unique(d$who))
  half <- qt((1 + confidence) / 2, n - 1) * se
  at_one <- c(1, -centre)
  c(intercept = b[[1]] - centre * b[[2]], exponent = b[[2]], se = se, ci.0 = b[[2]] - half,
    ci.1 = b[[2]] + half, sd_intercept = sqrt(max(at_one %*% g %*% at_one, 0)),
    sd_exponent = sqrt(g[2, 2]), sd_residual = residual, log_likelihood_reml = as.numeric(logLik(m)),
    n = n, trials = nrow(d))
}

order_effects <- function(trials, confidence) {
  if (!any(before <- startsWith(names(trials), "before_"))) return(NULL)
  trials$before <- trials[, before]
  d <- trials[!is.na(trials$before) & !is.na(trials$log), ]
  people <- unique(d$who)
  if (length(people) < 3) return(NULL)
  fit <- function(part) tail(coef(lm(log ~ factor(who) + factor(item) + position + before, part)), 2)
  whole <- fit(d)
  each <- sapply(people, function(person) fit(d[d$who != person, ]))
  n <- length(people)
  se <- sqrt((n - 1) / n * rowSums((each - whole)^2))
  c(under("position.", student(whole[[1]], se[[1]], n - 1, n, confidence)),
    under("carry_over.", student(whole[[2]], se[[2]], n - 1, n, confidence)))
}

reliability <- function(trials, confidence) {
  trials$level <- trials$item
  d <- trials[!is.na(trials$log), ]
  counts <- table(d$who, d$level)
  counts <- counts[, colSums(counts) > 0, drop = FALSE]
  n <- nrow(counts)
  k <- ncol(counts)
  if (n < 3 || max(counts) < 2) return(NULL)
  balanced <- min(counts) == max(counts)
  r <- if (balanced) max(counts) else 1 / mean(1 / counts[counts > 0])
  people <- rownames(counts)
  block <- lapply(people, function(i) d[d$who == i, ])
  # -2 log restricted likelihood of a model of all single estimates, and the variance of repetitions.
  restricted <- function(logs, people) {
    known <- sort(unique(unlist(lapply(people, function(p) p$level))))
    parts <- lapply(people, function(p) {
      v <- diag(nrow(p)) + exp(logs[1]) + exp(logs[2]) * outer(p$level, p$level, "==")
      x <- outer(p$level, known, "==") * 1
      list(xx = t(x) %*% solve(v, x), xy = t(x) %*% solve(v, p$log), yy = sum(p$log * solve(v, p$log)),
           det = as.numeric(determinant(v)$modulus))
    })
    sum_of <- function(name) Reduce(`+`, lapply(parts, `[[`, name))
    left <- sum(sapply(people, nrow)) - length(known)
    scale <- (sum_of("yy") - sum(sum_of("xy") * solve(sum_of("xx"), sum_of("xy")))) / left
    c(sum_of("det") + as.numeric(determinant(sum_of("xx"))$modulus) + left * log(scale), scale)
  }
  components <- function(b) {
    if (!balanced) {
      fits <- lapply(list(c(0, -0.7), c(-3, -3)), function(start)
        optim(start, function(logs) restricted(logs, b)[1], control = list(reltol = 1e-13)))
      best <- fits[[which.min(sapply(fits, function(f) f$value))]]$par
      return(c(exp(best), 1) * restricted(best, b)[2])
    }
    m <- length(b)
    cells <- t(sapply(b, function(p) tapply(p$log, p$level, mean)))
    if (k == 1) cells <- t(cells)
    centred <- sweep(cells, 2, colMeans(cells))
    own <- rowMeans(centred)
    error <- sum(sapply(b, function(p) sum((p$log - ave(p$log, p$level))^2))) / (m * k * (r - 1))
    mixed <- if (k > 1) r * sum((centred - own)^2) / ((m - 1) * (k - 1)) else error
    c((k * r * sum(own^2) / (m - 1) - mixed) / (k * r), (mixed - error) / r, error)
  }
  of <- function(b, times) {
    v <- components(b)
    (v[1] + v[2]) / (v[1] + v[2] + v[3] / times)
  }
  v <- components(block)
  out <- c(variance_participants = max(v[1], 0), variance_interaction = max(v[2], 0),
           variance_repetitions = v[3], n = n, levels = k, repetitions = r, trials = nrow(d))
  for (name in c("single", "mean")) {
    times <- if (name == "single") 1 else r
    value <- of(block, times)
    each <- sapply(seq_len(n), function(i) of(block[-i], times))
    pseudo <- n * atanh(value) - (n - 1) * atanh(each)
    ends <- tanh(mean(pseudo) + c(-1, 1) * qt((1 + confidence) / 2, n - 1) * sd(pseudo) / sqrt(n))
    out <- c(out, under(paste0(name, "."), c(value = value, ci.0 = ends[1], ci.1 = ends[2])))
  }
  out
}

# Growth functions: logarithm, search limits, starting points and reported parameters.
growth_functions <- function(x) {
  lx <- log(x)
  least <- min(x)
  most <- max(x)
  below <- least * (1 - 1e-6)
  softplus <- function(z) ifelse(z > 0, z + log1p(exp(-abs(z))), log1p(exp(-abs(z))))
  middle <- expand.grid(c(0.5, 2), seq(min(lx), max(lx), length.out = 3))
  list(
    power = list(f = function(q) q[1] * lx, low = -20, high = 20, starts = list(1),
                 as = function(q) c(exponent = q[1])),
    threshold = list(f = function(q) q[1] * log(x - q[2]), low = c(-20, -10 * most), high = c(20, below),
                     starts = list(c(1, 0), c(0.5, 0.5 * least), c(0.3, 0.95 * least), c(1, -most)),
                     as = function(q) c(exponent = q[1], threshold = q[2])),
    linear = list(f = function(q) log(x + q[1]), low = -below, high = 1000 * most,
                  starts = list(0, -0.5 * least, -0.9 * least, 2 * most), as = function(q) c(offset = q[1])),
    fechner = list(f = function(q) log(lx - q[1]), low = min(lx) - 50, high = min(lx) - 1e-6,
                   starts = list(min(lx) - 0.1, min(lx) - 2, min(lx) - 10),
                   as = function(q) c(threshold = exp(q[1]))),
    ekman = list(f = function(q) softplus(q[1] * (lx - q[2])), low = c(0, min(lx) - 7), high = c(20, max(lx) + 7),
                 starts = asplit(as.matrix(middle), 1),
                 as = function(q) c(exponent = q[[1]], doubling_stimulus = exp(q[[2]]))),
    naka_rushton = list(f = function(q) -softplus(q[1] * (q[2] - lx)), low = c(0, min(lx) - 7),
                        high = c(20, max(lx) + 7), starts = asplit(as.matrix(middle), 1),
                        as = function(q) c(exponent = q[[1]], half_saturation = exp(q[[2]]))))
}
growth <- function(logs, levels, wanted) {
  usable <- logs[, levels > 0, drop = FALSE]
  usable <- usable[rowSums(!is.na(usable)) >= 2, , drop = FALSE]
  here <- !is.na(usable)
  centred <- usable - rowMeans(usable, na.rm = TRUE)
  found <- list()
  for (name in wanted) {
    of <- growth_functions(levels[levels > 0])[[name]]
    cost <- function(q) {
      f <- matrix(suppressWarnings(of$f(q)), nrow(usable), ncol(usable), byrow = TRUE)
      f[!here] <- NA
      value <- sum((centred - (f - rowMeans(f, na.rm = TRUE)))^2, na.rm = TRUE)
      if (is.finite(value) && all(is.finite(f[here]))) value else 1e10
    }
    fits <- lapply(of$starts, function(start) nlminb(
      as.numeric(start), cost, lower = of$low, upper = of$high, scale = 1 / pmax(abs(as.numeric(start)), 1e-3),
      control = list(rel.tol = 1e-14, eval.max = 5000, iter.max = 5000)))
    best <- fits[[which.min(sapply(fits, `[[`, "objective"))]]
    points <- sum(here)
    estimated <- length(of$low) + nrow(usable) + 1
    squares <- max(best$objective, 1e-300)
    ll <- -points / 2 * (log(2 * pi * squares / points) + 1)
    spare <- points - estimated - 1
    found[[name]] <- c(under("parameters.", of$as(best$par)), sd = sqrt(squares / max(spare + 2, 1)),
                       log_likelihood = ll, aic = 2 * estimated - 2 * ll, bic = estimated * log(points) - 2 * ll,
                       points = points, estimated = estimated,
                       aicc = if (spare > 0) 2 * estimated - 2 * ll + 2 * estimated * (estimated + 1) / spare else NA)
  }
  scores <- sapply(found, `[[`, "aicc")
  delta <- scores - min(scores, na.rm = TRUE)
  weights <- exp(-delta / 2) / sum(exp(-delta / 2), na.rm = TRUE)
  c(unlist(lapply(names(found), function(name) under(
    paste0("of_level.models.", name, "."),
    c(found[[name]], delta_aicc = delta[[name]], weight = weights[[name]])))), of_level.n = nrow(usable))
}

clustered_interval <- function(yes, answers, confidence) {
  people <- length(answers)
  total <- sum(answers)
  share <- sum(yes) / total
  tail <- (1 - confidence) / 2
  n <- total
  if (people == 1 && total > 1) return(c(0, 1))
  if (people != total) {
    independent <- share * (1 - share) / total
    n <- people
    if (independent > 0) {
      clustered <- people / (people - 1) * sum((yes - share * answers)^2) / total^2
      n <- min(total / max(clustered / independent, 1) * (qt(tail, total - 1) / qt(tail, people - 1))^2, total)
    }
  }
  k <- share * n
  c(if (k > 0) qbeta(tail, k, n - k + 1) else 0, if (k < n) qbeta(1 - tail, k + 1, n - k) else 1)
}
d_prime <- function(counts) {
  z <- qnorm((counts[c(1, 3)] + 0.5) / (counts[c(2, 4)] + 1))
  c(z[1] - z[2], -sum(z) / 2)
}

difference <- function(rows, settings, confidence) {
  before <- rows[[settings[["before"]]]]
  after <- rows[[settings[["after"]]]]
  felt <- rows[[settings[["answer"]]]]
  who <- rows$participant_id
  catch <- before == after
  share <- function(part) {
    yes <- tapply(felt[part], who[part], sum)
    ends <- clustered_interval(yes, tapply(felt[part], who[part], length), confidence)
    c(n = sum(part), yes = sum(felt[part]), ci.0 = ends[1], ci.1 = ends[2])
  }
  kinds <- unique(data.frame(before, after)[!catch, ])
  kinds <- kinds[order(-kinds$before, -kinds$after), ]
  out <- c(participants = length(unique(who)), catch.n = sum(catch), catch.yes = sum(felt[catch]))
  for (i in seq_len(nrow(kinds))) out <- c(out, under(
    paste0("steps.", i - 1, "."), share(before == kinds$before[i] & after == kinds$after[i])))
  if (any(catch)) out <- c(out, under("catch.", share(catch))[c("catch.ci.0", "catch.ci.1")])
  out["answers_per_participant_and_step"] <- sum(!catch) / nrow(unique(data.frame(who, before, after)[!catch, ]))
  if (any(catch) && any(!catch)) {
    names4 <- c("hits", "changes", "false_alarms", "catches")
    counts <- function(one) c(sum(felt[one & !catch]), sum(one & !catch), sum(felt[one & catch]), sum(one & catch))
    pooled <- counts(TRUE)
    s <- c(pooled_d_prime = d_prime(pooled)[1], pooled_criterion = d_prime(pooled)[2], setNames(pooled, names4))
    own <- NULL
    for (person in intersect(who[!catch], who[catch])) {
      each <- counts(who == person)
      d <- d_prime(each)
      own <- c(own, d[1])
      s <- c(s, under(paste0("participants.", person, "."), c(setNames(each, names4), d_prime = d[1], criterion = d[2])))
    }
    s <- c(s, under("mean_of_participants.", mean_test(own, confidence)), by_size(felt, before, after, who, confidence))
    out <- c(out, d_prime = s[["pooled_d_prime"]], under("signal_detection.", s))
  }
  base <- rows[[settings[["weber_base"]]]]
  logarithmic <- settings[["axis"]] == "logarithmic"
  some <- base > 0
  c(out, under("psychometric.", curve(felt, before - after, who, confidence, logarithmic)),
    under("weber.", curve(felt[some], (abs(before - after) / base)[some], who[some], confidence, logarithmic)))
}

# Generalised estimating equations with exchangeable correlation and Mancl-DeRouen standard errors.
curve <- function(felt, removed, who, confidence, logarithmic) {
  if (logarithmic) {
    above <- removed > 0
    felt <- felt[above]
    who <- who[above]
    removed <- log(removed[above])
  }
  back <- if (logarithmic) exp else identity
  x <- cbind(1, removed)
  groups <- split(seq_along(felt), who)
  n <- length(groups)
  if (n < 3 || length(unique(removed)) < 2) return(NULL)
  b <- c(0, 0)
  alpha <- 0
  parts <- function(b, alpha, use) {
    mu <- plogis(as.vector(x %*% b))
    lapply(groups, function(g) {
      d <- x[g, , drop = FALSE] * (mu[g] * (1 - mu[g]))
      a <- sqrt(mu[g] * (1 - mu[g]))
      v <- outer(a, a) * (alpha + diag(1 - alpha, length(g)))
      inverse <- tryCatch(solve(v), error = function(e) v * NA)
      use(d, inverse, felt[g] - mu[g], (felt[g] - mu[g]) / a)
    })
  }
  for (i in seq_len(500)) {
    left <- Reduce(`+`, parts(b, alpha, function(d, w, r, z) t(d) %*% w %*% d))
    right <- Reduce(`+`, parts(b, alpha, function(d, w, r, z) t(d) %*% w %*% r))
    step <- tryCatch(as.vector(solve(left, right)), error = function(e) NULL)
    if (is.null(step) || any(!is.finite(step))) return(NULL)
    b <- b + step
    z <- parts(b, alpha, function(d, w, r, z) c(sum(z^2), (sum(z)^2 - sum(z^2)) / 2, length(z) * (length(z) - 1) / 2))
    z <- Reduce(`+`, z)
    alpha <- z[2] / (z[1] / (length(felt) - 2)) / (z[3] - 2)
    if (sum(step^2) < 1e-22) break
  }
  bread <- solve(Reduce(`+`, parts(b, alpha, function(d, w, r, z) t(d) %*% w %*% d)))
  meat <- Reduce(`+`, parts(b, alpha, function(d, w, r, z) {
    s <- t(d) %*% w %*% solve(diag(length(r)) - d %*% bread %*% t(d) %*% w, r)
    s %*% t(s)
  }))
  v <- bread %*% meat %*% bread
  se <- sqrt(v[2, 2])
  t <- b[2] / se
  quantile <- qt((1 + confidence) / 2, n - 2)
  half <- quantile * se
  # Fieller's theorem: sizes at which the line is within t standard errors of 0.
  square <- b[2]^2 - quantile^2 * v[2, 2]
  middle <- b[1] * b[2] - quantile^2 * v[1, 2]
  root <- sqrt(max(middle^2 - square * (b[1]^2 - quantile^2 * v[1, 1]), 0))
  ends <- if (b[2] > 0 && square > 0) (-middle + c(-root, root)) / square else c(NA, NA)
  odds <- b[1] + b[2] * sort(unique(removed))
  gap <- which(odds[-length(odds)] < -log(9) & odds[-1] > log(9))
  between <- if (length(gap)) setNames(back(sort(unique(removed))[gap[1] + 0:1]), c("half_yes_between.0", "half_yes_between.1"))
  # With few degrees of freedom, each participant's own curve.
  own <- if (n <= 5) unlist(lapply(split(data.frame(felt, removed), who), function(d) {
    yes <- d$removed[d$felt == 1]
    no <- d$removed[d$felt == 0]
    if (!length(yes) || !length(no) || max(min(yes) - max(no), min(no) - max(yes)) >= 0) return(NULL)
    summary(glm(felt ~ removed, binomial, d))$coefficients[2, 3]
  }))
  if (length(own)) names(own) <- paste0("own_z.", names(own))
  c(log_odds_per_unit = b[2], se = se, ci.0 = b[2] - half, ci.1 = b[2] + half, t = t, df = n - 2,
    p = 2 * pt(-abs(t), n - 2), intercept = b[1], correlation = alpha, n = n, answers = length(felt),
    half_yes = if (b[2] > 0) back(-b[1] / b[2]) else NA, half_yes_ci.0 = back(ends[1]), half_yes_ci.1 = back(ends[2]), between, own)
}

# d' for each step size from a probit model with participant effects and profile likelihood.
by_size <- function(felt, before, after, who, confidence) {
  largest <- max(abs(before), abs(after))
  size <- round(before - after, -ceiling(log10(largest * 1e-9)))
  people <- length(unique(who))
  if (people < 3) return(NULL)
  drop <- people / 2 * log(1 + qt((1 + confidence) / 2, people - 1)^2 / (people - 1))
  kinds <- sort(unique(size[size != 0]))
  out <- NULL
  for (i in seq_along(kinds)) out <- c(out, under(paste0("by_size.", i - 1, "."), c(
    steps = sum(size == kinds[i]), yes = sum(felt[size == kinds[i]]), profile_of(size, kinds, i, felt, who, drop))))
  c(out, under("all_sizes.", c(steps = sum(size != 0), yes = sum(felt[size != 0]),
                               profile_of(as.numeric(size != 0), 1, 1, felt, who, drop))))
}
profile_of <- function(size, kinds, place, felt, who, drop, far = 8) {
  yes <- sapply(c(0, kinds), function(k) tapply(felt * (size == k), who, sum))
  all <- sapply(c(0, kinds), function(k) tapply(size == k, who, sum))
  # People differ in criterion and, for steps, in sensitivity. Few answers cannot separate the two.
  differ <- min(mean(all[, 1]), mean(rowSums(all[, -1, drop = FALSE]))) >= 5
  grid <- function(count) {
    nodes <- seq(-5.5, 5.5, length.out = count)
    list(nodes = nodes, weights = dnorm(nodes, log = TRUE) + log(nodes[2] - nodes[1]))
  }
  first <- grid(45)
  second <- if (differ) grid(15) else list(nodes = 0, weights = 0)
  log_sums <- function(terms) {
    peak <- terms[cbind(seq_len(nrow(terms)), max.col(terms, "first"))]
    peak + log(rowSums(exp(terms - peak)))
  }
  likelihood <- function(columns, z) yes[, columns, drop = FALSE] %*% pnorm(z, log.p = TRUE) +
    (all - yes)[, columns, drop = FALSE] %*% pnorm(-z, log.p = TRUE)
  minus_log <- function(theta) {
    m <- length(kinds)
    at <- -theta[m + 1] - theta[m + 2] * first$nodes
    steps <- outer(theta[seq_len(m)], as.vector(outer(at, theta[m + 3] * second$nodes, `+`)), `+`)
    within <- sweep(likelihood(1 + seq_len(m), steps), 2, rep(second$weights, each = length(at)), `+`)
    within <- log_sums(matrix(within, ncol = length(second$nodes)))
    terms <- likelihood(1, matrix(at, 1)) + matrix(within, nrow(yes))
    -sum(log_sums(sweep(terms, 2, first$weights, `+`)))
  }
  low <- c(rep(-far, length(kinds) + 1), 0, 0)
  high <- c(rep(far, length(kinds) + 1), 4, if (differ) 4 else 0)
  fit <- function(start, held = NULL) {
    spreads <- length(start) - 1:0
    free <- setdiff(which(high > low), if (!is.null(held)) place)
    if (!is.null(held)) start[place] <- held
    # At a spread of 0, the gradient is 0, so a search that starts there does not move.
    start[spreads] <- pmin(pmax(start[spreads], 0.3), high[spreads])
    of <- function(q) minus_log(replace(start, free, q))
    first <- nlminb(start[free], of, lower = low[free], upper = high[free], control = list(rel.tol = 1e-13))
    # nlminb stops early on a narrow ridge; the other optimiser continues from there.
    then <- optim(first$par, of, method = "L-BFGS-B", lower = low[free], upper = high[free],
                  control = list(factr = 1e5, maxit = 1000))
    list(par = replace(start, free, then$par), objective = then$value)
  }
  best <- fit(c(rep(1, length(kinds)), 0.5, 0.5, 0.5))
  ends <- list(fit(best$par, -far), fit(best$par, far))
  for (end in ends) if (end$objective < best$objective) best <- end
  beyond <- function(value) fit(best$par, value)$objective - best$objective - drop
  out <- NULL
  if (ends[[1]]$objective - best$objective > drop) out["ci.0"] <- uniroot(beyond, c(-far, best$par[place]), f.lower = ends[[1]]$objective - best$objective - drop, f.upper = -drop, tol = 1e-4)$root
  if (ends[[2]]$objective - best$objective > drop) out["ci.1"] <- uniroot(beyond, c(best$par[place], far), f.lower = -drop, f.upper = ends[[2]]$objective - best$objective - drop, tol = 1e-4)$root
  if (min(ends[[1]]$objective, ends[[2]]$objective) - best$objective >= 1e-3) out["d_prime"] <- best$par[place]
  out
}

prepared <- function(settings) {
  trials <- read("estimates.csv")
  if (is.null(trials) || !nrow(trials)) return(NULL)
  names(trials)[names(trials) == settings[["level"]]] <- "level"
  names(trials)[names(trials) == "participant_id"] <- "who"
  # Trials of the same level in the same condition are repetitions.
  trials$item <- as.integer(interaction(c(list(trials$level), trials[startsWith(names(trials), "factor: ")]), drop = TRUE))
  values <- trials$normalised
  if (settings[["zero_rule"]] == "half_minimum") values[values <= 0] <- min(values[values > 0]) / 2
  trials$log <- ifelse(values > 0, log(pmax(values, 1e-300)), NA)
  mean_of <- function(v) if (all(is.na(v))) NA else mean(v, na.rm = TRUE)
  # The mean of condition means, missing where a person lacks a condition that others have.
  named <- grep("^factor: ", names(trials), value = TRUE)
  named <- named[vapply(named, function(name) length(unique(trials[[name]])) > 1, NA)]
  condition <- do.call(paste, c(list(rep("", nrow(trials))), trials[named], sep = "\n"))
  over_conditions <- function(v) {
    means <- tapply(v, list(trials$who, trials$level, condition), mean_of)
    there <- !is.na(means)
    wanted <- aperm(array(apply(there, c(2, 3), any), dim(there)[c(2, 3, 1)]), c(3, 1, 2))
    own <- apply(there, c(1, 3), any)
    if (!any(apply(own, 1, all))) wanted <- wanted & aperm(array(own, dim(there)[c(1, 3, 2)]), c(1, 3, 2))
    found <- apply(means, c(1, 2), mean_of)
    found[apply(wanted & !there, c(1, 2), any)] <- NA
    found
  }
  cells <- over_conditions(trials$normalised)
  logs <- over_conditions(trials$log)
  list(trials = trials, cells = cells, logs = logs)
}

estimates <- function(settings, names_wanted, data) {
  if (is.null(data)) return(NULL)
  trials <- data$trials
  cells <- data$cells
  logs <- data$logs
  confidence <- as.numeric(settings[["confidence"]])
  levels <- as.numeric(colnames(cells))
  law <- power_law(logs, levels, confidence)
  ranks <- friedman(cells)
  out <- c(
    descriptives(cells, logs, confidence, settings[["standard_deviation"]] == "sample", as.numeric(settings[["largest_mean"]])),
    under("friedman.", ranks), under("power_law.", law), under("rm_anova.", rm_anova(logs, confidence)),
    under("page_trend.", page_trend(cells)),
    under("linear_trend.", linear_trend(logs, levels, confidence)),
    if (ncol(cells) > 1) pairwise(cells, logs, confidence, as.numeric(settings[["equivalence_ratio"]])),
    under("individuals.", setNames(slopes(logs, levels), paste0(rownames(logs), ".exponent"))))
  wants <- function(part) any(startsWith(names_wanted, part))
  if (wants("robust_exponent.")) out <- c(out, under("robust_exponent.", robust_exponent(trials, confidence)))
  if (wants("mixed_model.")) out <- c(out, under("mixed_model.", mixed_model(trials, confidence)))
  if (wants("order.")) out <- c(out, under("order.", order_effects(trials, confidence)))
  if (wants("reliability.")) out <- c(out, under("reliability.", reliability(trials, confidence)))
  models <- regmatches(names_wanted, regexpr("(?<=^growth\\.of_level\\.models\\.)[a-z_]+", names_wanted, perl = TRUE))
  if (length(models)) out <- c(out, under("growth.", growth(logs, levels, unique(models))))
  quality <- read("quality.csv")
  flagged <- quality$participant_id[!is.na(quality$flags)]
  subsets <- list(rownames(cells), setdiff(rownames(cells), flagged))
  for (i in 1:2) {
    c_ <- cells[subsets[[i]], , drop = FALSE]
    f <- friedman(c_)
    l <- power_law(logs[subsets[[i]], , drop = FALSE], levels, confidence)
    at <- function(v, name) if (is.null(v)) NA else v[[name]]
    out <- c(out, under(paste0("robustness.", i - 1, "."), c(
      n = nrow(c_), friedman_chi2 = at(f, "chi2"), friedman_p = at(f, "p"), exponent = at(l, "exponent"),
      exponent_ci.0 = at(l, "ci.0"), exponent_ci.1 = at(l, "ci.1"),
      setNames(colMeans(c_, na.rm = TRUE), paste0("means.", seq_along(levels) - 1)))))
  }
  out
}

main <- function() {
  script <- sub("^--file=", "", grep("^--file=", commandArgs(), value = TRUE))
  if (length(script)) setwd(dirname(script))
  table <- read.csv("settings.csv", colClasses = "character")
  settings <- setNames(table$value, table$name)
  reported <- read("numbers.csv")
  # Results for the level have the name of its quantity.
  noun <- settings[["of_level"]]
  wanted <- gsub(paste0("\\b", noun, "\\b"), "of_level", reported$name)
  data <- prepared(settings)
  found <- estimates(settings, wanted, data)
  answers <- read("answers.csv")
  if (!is.null(answers) && nrow(answers)) {
    found <- c(found, under("difference.", difference(answers, settings, as.numeric(settings[["confidence"]]))))
  }
  if (file.exists("recompute_tasks.R")) {
    source("recompute_tasks.R")
    found <- c(found, tasks(settings, wanted, data$trials, data$logs))
  }
  names(found) <- gsub("\\bof_level\\b", noun, names(found))
  differ <- 0
  missing <- NULL
  for (i in seq_len(nrow(reported))) {
    name <- reported$name[i]
    value <- reported$value[i]
    ours <- if (name %in% names(found)) found[[name]] else NA
    if (!is.finite(ours)) {
      missing <- c(missing, name)
      next
    }
    close <- if (grepl(fitted, name)) close_fits else if (grepl(on_grids, name)) close_grids else close_enough
    smallest <- if (grepl("\\.(lapse|guess)$|^factors\\..*mixed", name)) 5e-2 else 1e-2
    same <- abs(ours - value) <= close * max(abs(value), smallest)
    if (grepl("log_likelihood_reml", name)) same <- abs(ours - value) < same_maximum
    if (grepl("^mixed_model\\.sd_", name)) {
      same <- same || max(ours, value) < almost_none * found[["mixed_model.sd_residual"]]
    }
    if (grepl("population\\.sd$", name)) {
      width <- 1 / found[[sub("sd$", "slope.value", name)]]
      same <- same || max(ours, value) < barely * width
    }
    if (!same) differ <- differ + 1
    cat(sprintf("%-60s %18.10g %18.10g%s\n", name, value, ours, if (same) "" else "   DIFFERS"))
  }
  cat(nrow(reported) - length(missing), "of", nrow(reported), "numbers recomputed,", differ, "differ\n")
  if (length(missing)) cat(paste0("not recomputed: ", missing, "\n"), sep = "")
  if (differ) quit(status = 1)
}
main()
