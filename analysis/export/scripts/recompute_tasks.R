# Thresholds, scales, matches, ratings, ratios, productions, groups and sessions. If this file is in the
# folder of recompute.R, recompute.R reads it and compares its results with numbers.csv.

in_code_order <- function(values) sort(unique(values[!is.na(values)]), method = "radix")
# Numbers in labels padded with zeros, so that sorting puts 80 before 320.
padded <- function(labels) {
  at <- gregexpr("[0-9]+(\\.[0-9]+)?", labels)
  regmatches(labels, at) <- lapply(regmatches(labels, at), function(n) sprintf("%020.6f", as.numeric(n)))
  labels
}
in_padded_order <- function(labels) {
  labels <- unique(labels)
  labels[order(padded(labels), method = "radix")]
}
numbers_first <- function(values) {
  labels <- unique(as.character(values))
  number <- suppressWarnings(as.numeric(labels))
  labels[order(is.na(number), number, labels, method = "radix")]
}
numbered <- function(prefix, parts) unlist(lapply(seq_along(parts), function(i) under(paste0(prefix, i - 1, "."), parts[[i]])))
mean_and_ends <- function(x, confidence) mean(x) + c(0, -1, 1) * qt((1 + confidence) / 2, length(x) - 1) * sd(x) / sqrt(length(x))
three <- function(name, values) setNames(values, paste0(name, c(".value", ".interval.0", ".interval.1")))
person_means <- function(value, who, column) tapply(value, list(who, column), mean)

# Psychometric functions of the level or its logarithm ---------------------------------------------

largest_lapse <- 0.06
families <- list(
  gumbel = list(share = function(z) -expm1(-exp(pmin(z, 700))), inverse = function(p) log(-log1p(-p))),
  logistic = list(share = plogis, inverse = qlogis), normal = list(share = pnorm, inverse = qnorm))
psychometric <- function(method, settings) {
  compared <- method == "comparison"
  guess <- switch(method, two_interval = 1 / 2, three_interval = 1 / 3, oddity = 1 / 3, NA)
  name <- settings[["threshold_curve"]]
  if (name == "") name <- if (compared) "normal" else "weibull"
  logarithmic <- name %in% c("weibull", "log_logistic", "log_normal")
  if (settings[["axis"]] != "" && logarithmic != (settings[["axis"]] == "logarithmic")) {
    pairs <- c(weibull = "gumbel", log_logistic = "logistic", log_normal = "normal")
    pairs <- c(pairs, setNames(names(pairs), pairs))
    name <- pairs[[name]]
    logarithmic <- !logarithmic
  }
  family <- families[[if (name == "weibull") "gumbel" else sub("log_", "", name)]]
  offset <- family$inverse(as.numeric(settings[["threshold_share"]]))
  list(
    compared = compared, guess = guess, logarithmic = logarithmic,
    largest_lapse = as.numeric(settings[["largest_lapse"]]),
    at = function(levels) if (logarithmic) log(ifelse(levels > 0, levels, 1e-300)) else levels,
    back = if (logarithmic) exp else identity,
    share = function(away, slope) family$share(offset + slope * away),
    p_of = function(share, lapse) {
      low <- if (compared) lapse else guess
      pmin(pmax(low + (1 - low - lapse) * share, 1e-9), 1 - 1e-9)
    },
    # For a slope of 1: distance from 5 to 95 %, and half the distance from 25 to 75 %.
    spread = family$inverse(0.95) - family$inverse(0.05),
    half_width = (family$inverse(0.75) - family$inverse(0.25)) / 2)
}

# Threshold, log slope and lapse rate by maximum likelihood; NULL if answers jump between levels.
likeliest <- function(curve, x, yes, n) {
  seen <- x[x > -600]
  span <- diff(range(seen))
  steps <- diff(seen)
  closest <- min(steps[steps > span / 200], span)
  low <- c(min(seen) - span, log(curve$spread / 20 / span), 0)
  high <- c(max(seen) + span, log(10 * curve$spread / closest), largest_lapse)
  minus <- function(q) {
    p <- curve$p_of(curve$share(x - q[1], exp(q[2])), q[3])
    -sum(yes * log(p) + (n - yes) * log1p(-p))
  }
  search <- function(start, low, high) nlminb(start, minus, lower = low, upper = high,
                                              control = list(rel.tol = 1e-14, iter.max = 2000, eval.max = 5000))
  starts <- expand.grid(min(seen) + span * seq(0, 1, length.out = 7), log(curve$spread / span / c(2, 0.5, 0.15)), c(0.001, 0.05))
  costs <- apply(starts, 1, minus)
  fits <- lapply(order(costs)[1:4], function(i) search(as.numeric(starts[i, ]), low, high))
  best <- fits[[which.min(sapply(fits, `[[`, "objective"))]]
  held <- min(sapply(seq(min(seen), max(seen), length.out = 9), function(at)
    search(c(at, high[2], best$par[3]), replace(low, 2, high[2]), high)$objective))
  if (held - best$objective < 0.05 || high[2] - best$par[2] < log(30)) NULL else best$par
}

# Posterior medians and intervals of threshold and log slope, and mean lapse rate, on a grid. Priors:
# threshold uniform up to one range of levels beyond the outermost levels; slope log-normal (SD 0.6)
# with median 2, or for comparisons a rise from 5 to 95 % over the levels; lapse rate uniform to 6 %.
posterior <- function(curve, x, yes, n, confidence) {
  seen <- x[x > -600]
  span <- diff(range(seen))
  usual <- if (curve$logarithmic) 2 else curve$spread / span
  lapses <- (seq_len(12) - 0.5) / 12 * largest_lapse
  weights <- function(at, slopes) {
    value <- array(0, c(length(at), length(slopes), length(lapses)))
    for (j in seq_along(x)) {
      share <- curve$share(outer(x[j] - at, exp(slopes)), 1)
      for (i in seq_along(lapses)) {
        p <- curve$p_of(share, lapses[i])
        value[, , i] <- value[, , i] + yes[j] * log(p) + (n[j] - yes[j]) * log1p(-p)
      }
    }
    value <- sweep(value, 2, ((slopes - log(usual)) / 0.6)^2 / 2)
    value <- exp(value - max(value))
    value / sum(value)
  }
  zoomed <- function(values, mass, points) {
    there <- which(mass > 1e-7 * max(mass))
    seq(values[max(min(there) - 1, 1)], values[min(max(there) + 1, length(values))], length.out = points)
  }
  at <- seq(min(seen) - span, max(seen) + span, length.out = 80)
  slopes <- log(usual) + 0.6 * seq(-3.5, 3.5, length.out = 40)
  found <- weights(at, slopes)
  at <- zoomed(at, apply(found, 1, sum), 120)
  slopes <- zoomed(slopes, apply(found, 2, sum), 50)
  found <- weights(at, slopes)
  ends <- function(values, mass) approx(cumsum(mass) - mass / 2, values, c(0.5, (1 - confidence) / 2, (1 + confidence) / 2), rule = 2, ties = "ordered")$y
  list(at = ends(at, apply(found, 1, sum)), slope = ends(slopes, apply(found, 2, sum)), lapse = sum(apply(found, 3, sum) * lapses))
}

threshold_of <- function(rows, method, standard, confidence, settings) {
  main <- rows[!rows$catch, ]
  catch <- rows[rows$catch, ]
  right <- function(part) {
    if (method != "comparison") return(sum(part$correct))
    more <- part$track_level - part$standard_level
    sum(part$correct & more > 0) + sum(!part$correct & more < 0)
  }
  out <- c(trials = nrow(main), correct = right(main), catch_trials = nrow(catch), catch_correct = right(catch))
  levels <- sort(unique(main$track_level))
  yes <- sapply(levels, function(level) sum(main$correct[main$track_level == level]))
  n <- sapply(levels, function(level) sum(main$track_level == level))
  curve <- psychometric(method, settings)
  x <- curve$at(levels)
  if (length(x) < 2 || sum(yes) %in% c(0, sum(n))) return(out)
  back <- curve$back
  shared <- function(lapse) c(lapse = lapse, guess = if (curve$compared) lapse else curve$guess, trials = nrow(main), levels = length(x))
  ours <- posterior(curve, x, yes, n, confidence)
  out <- c(out, under("function.", c(
    threshold = back(ours$at[1]), threshold_ci.0 = back(ours$at[2]), threshold_ci.1 = back(ours$at[3]),
    slope = exp(ours$slope[1]), slope_ci.0 = exp(ours$slope[2]), slope_ci.1 = exp(ours$slope[3]), shared(ours$lapse))))
  best <- likeliest(curve, x, yes, n)
  if (!is.null(best)) {
    p <- curve$p_of(curve$share(x - best[1], exp(best[2])), best[3])
    own <- pmin(pmax(yes / n, 1e-9), 1 - 1e-9)
    gained <- sum(yes * log(own / p) + (n - yes) * log((1 - own) / (1 - p)))
    out <- c(out, fit.deviance = 2 * gained)
  }
  if (is.na(standard)) return(out)
  half <- curve$half_width / exp(ours$slope[c(1, 3, 2)])
  if (curve$logarithmic) half <- back(ours$at)[1] * sinh(half)
  weber <- if (curve$compared) half else back(ours$at)
  c(out, three("weber_fraction", weber / standard))
}

# Hierarchical model of all answers. Thresholds are normally distributed on the curve's axis, between
# people and between a person's sessions and conditions. With one session and condition, log slopes are
# normally distributed between people; otherwise there is one slope. There is one lapse rate. The fit
# maximises the marginal likelihood, in which random effects are summed on grids. Intervals use the
# profile likelihood with a t quantile.
population_of <- function(rows, curve, standard, confidence) {
  main <- rows[!rows$catch, ]
  people <- in_code_order(main$participant_id)
  n <- length(people)
  if (n < 3) return(NULL)
  # Labels of session and of conditions.
  factors <- main[grepl("^factor: ", names(main))]
  main$session <- do.call(paste, c(list(ifelse(is.na(main$session), "", main$session)), factors))
  sessions <- in_code_order(main$session)
  levels <- sort(unique(main$track_level))
  x <- curve$at(levels)
  count <- function(which) lapply(sessions, function(s) {
    here <- main[main$session == s & which, ]
    unclass(table(factor(here$participant_id, people), factor(match(here$track_level, levels), seq_along(levels))))
  })
  yes <- count(main$correct)
  no <- count(!main$correct)
  catch <- rows[rows$catch & (!curve$compared | rows$track_level != rows$standard_level), ]
  right <- if (curve$compared) catch$correct == (catch$track_level > catch$standard_level) else catch$correct
  grid <- function(count, farthest = 5) {
    nodes <- seq(-farthest, farthest, length.out = count)
    list(nodes = nodes, weights = dnorm(nodes, log = TRUE) - log(sum(dnorm(nodes))))
  }
  none <- list(nodes = 0, weights = 0)
  several <- length(sessions) > 1
  outer_grid <- grid(max(25, ceiling((if (several) 3 else 8) * sqrt(max(table(main$participant_id))))), 4)
  of_slopes <- if (several) none else grid(7, 3)
  inner_grid <- if (several) grid(21) else none
  # All combinations of threshold and slope of a person.
  persons <- rep(outer_grid$nodes, length(of_slopes$nodes))
  slopes <- rep(of_slopes$nodes, each = length(outer_grid$nodes))
  weights <- as.vector(outer(outer_grid$weights, of_slopes$weights, `+`))
  log_sums <- function(terms) {
    peak <- terms[cbind(seq_len(nrow(terms)), max.col(terms, "first"))]
    peak + log(rowSums(exp(terms - peak)))
  }
  terms_of <- function(q) {
    at <- as.vector(outer(q[1] + q[3] * persons, q[4] * inner_grid$nodes, `+`))
    steep <- rep(rep(exp(q[2] + q[5] * slopes), length(inner_grid$nodes)), each = length(x))
    p <- curve$p_of(curve$share(outer(x, at, `-`), steep), q[6])
    terms <- matrix(weights, n, length(weights), byrow = TRUE)
    for (s in seq_along(sessions)) {
      within <- yes[[s]] %*% log(p) + no[[s]] %*% log1p(-p)
      within <- sweep(within, 2, rep(inner_grid$weights, each = length(weights)), `+`)
      terms <- terms + matrix(log_sums(matrix(within, ncol = length(inner_grid$nodes))), n)
    }
    terms
  }
  minus <- function(q) {
    lapse <- max(q[6], 1e-9)
    -sum(log_sums(terms_of(q))) - sum(right) * log1p(-lapse) - sum(!right) * log(lapse)
  }
  seen <- x[x > -600]
  span <- sd(seen)
  low <- c(mean(seen) - 6 * span, log(curve$spread / 20 / span), 0, 0, 0, 0)
  high <- c(mean(seen) + 6 * span, log(curve$spread / 0.02 / span), 5 * span, if (several) 5 * span else 0, if (several) 0 else 1.5, curve$largest_lapse)
  fit <- function(start, place = NULL, value = NULL) {
    start[3:5] <- pmin(pmax(start[3:5], 0.3 * c(span, span, 1)), high[3:5])
    if (!is.null(place)) start[place] <- value
    free <- setdiff(which(high > low), place)
    found <- nlminb(start[free], function(q) minus(replace(start, free, q)), lower = low[free], upper = high[free], control = list(rel.tol = 1e-9))
    list(par = replace(start, free, found$par), objective = found$objective)
  }
  starts <- expand.grid(lapse = pmin(c(0.005, 0.03, 0.1), curve$largest_lapse), width = c(3, 1.5, 0.8))
  starts <- lapply(seq_len(nrow(starts)), function(i) c(mean(seen), log(curve$spread / starts$width[i] / span), 0.5 * span, min(0.3 * span, high[4]), min(0.3, high[5]), starts$lapse[i]))
  starts <- starts[order(sapply(starts, minus))[1:3]]
  fits <- lapply(starts, fit)
  best <- fits[[which.min(sapply(fits, `[[`, "objective"))]]
  fall <- n / 2 * log(1 + qt((1 + confidence) / 2, n - 1)^2 / (n - 1))
  end <- function(place, edge) {
    beyond <- function(value) fit(best$par, place, value)$objective - best$objective - fall
    far <- beyond(edge)
    if (far <= 0) return(sign(edge - best$par[place]) * Inf)
    # The function is known at both ends; at the best value, it equals -fall.
    if (edge < best$par[place]) uniroot(beyond, c(edge, best$par[place]), f.lower = far, f.upper = -fall, tol = 1e-3 * span)$root
    else uniroot(beyond, c(best$par[place], edge), f.lower = -fall, f.upper = far, tol = 1e-3 * span)$root
  }
  ends <- function(place) c(best$par[place], end(place, low[place]), end(place, high[place]))
  threshold <- curve$back(ends(1))
  slope <- exp(ends(2))
  shares <- exp(terms_of(best$par))
  own <- best$par[1] + best$par[3] * as.vector(shares %*% persons) / rowSums(shares)
  half <- curve$half_width / slope[c(1, 3, 2)]
  if (curve$logarithmic) half <- threshold[1] * sinh(half)
  relative <- if (curve$compared) half else threshold
  c(three("population.threshold", threshold), three("population.slope", slope),
    population.sd = best$par[3] / (if (curve$logarithmic) log(10) else 1),
    if (!several) c(population.sd_log_slope = best$par[5]),
    if (curve$compared || !curve$logarithmic) three("population.half_width", half),
    population.lapse = best$par[6], population.n = n, population.answers = nrow(main),
    setNames(curve$back(own), paste0("population.participants.", people)),
    if (!is.na(standard)) three("weber_fraction", relative / standard))
}

thresholds <- function(choices, confidence, settings) {
  tasks <- in_padded_order(choices$task)
  unlist(lapply(seq_along(tasks), function(i) {
    rows <- choices[choices$task == tasks[i], ]
    method <- rows$method[1]
    standard <- unique(rows$standard_level[!is.na(rows$standard_level)])
    standard <- if (length(standard) == 1 && standard > 0) standard else NA
    people <- lapply(in_code_order(rows$participant_id), function(who) threshold_of(rows[rows$participant_id == who, ], method, standard, confidence, settings))
    under(paste0("thresholds.", i - 1, "."), c(
      standard = standard, numbered("participants.", people),
      population_of(rows, psychometric(method, settings), standard, confidence)))
  }))
}

# Exponent and Weber fraction of each task that has one, compared by Ekman's law.
agreement <- function(choices, exponents, found, confidence) {
  out <- list()
  tasks <- in_padded_order(choices$task)
  for (i in seq_along(tasks)) {
    people <- in_code_order(choices$participant_id[choices$task == tasks[i]])
    names_there <- paste0("thresholds.", i - 1, ".participants.", seq_along(people) - 1, ".weber_fraction.value")
    both <- names_there %in% names(found) & people %in% names(exponents)[!is.na(exponents)]
    if (sum(both) < 3) next
    weber <- unname(found[names_there[both]])
    power <- unname(exponents[people[both]])
    fraction <- unname(found[paste0("thresholds.", i - 1, ".weber_fraction", c(".value", ".interval.0", ".interval.1"))])
    out[[length(out) + 1]] <- c(
      standard = found[[paste0("thresholds.", i - 1, ".standard")]], three("exponent", mean_and_ends(power, confidence)),
      three("weber_fraction", fraction), three("expected_exponent", log(1.03) / log1p(fraction[c(1, 3, 2)])),
      three("ekman_fraction", expm1(mean_and_ends(power * log1p(weber), confidence))),
      numbered("participants.", Map(function(p, w) c(exponent = p, weber_fraction = w), power, weber)))
  }
  numbered("exponent_and_weber.", out)
}

# Scales -------------------------------------------------------------------------------------------

# Surfaces in ascending order of level, followed by textures sorted by name.
surfaces_in_order <- function(labels) {
  labels <- in_code_order(labels)
  labels[order(suppressWarnings(as.numeric(labels)), na.last = TRUE)]
}

# chosen: array (participants, surfaces, surfaces) that counts choices of the row over the column.
pair_scale <- function(chosen, link, confidence) {
  pooled <- apply(chosen, 2:3, sum)
  k <- nrow(pooled)
  people <- dim(chosen)[1]
  pairs <- which(upper.tri(pooled) & pooled + t(pooled) > 0, arr.ind = TRUE)
  one <- pairs[, 1]
  other <- pairs[, 2]
  design <- matrix(0, nrow(pairs), k)
  design[cbind(seq_along(one), one)] <- 1
  design[cbind(seq_along(one), other)] <- -1
  won <- pooled[pairs]
  lost <- t(pooled)[pairs]
  n <- won + lost
  cdf <- if (link == "logit") plogis else pnorm
  pdf <- if (link == "logit") dlogis else dnorm
  information <- function(linear) t(design) %*% (design * (n * pdf(linear)^2 / (cdf(linear) * cdf(-linear))))
  # Firth's correction: the likelihood times the square root of the determinant of the information.
  minus <- function(free) {
    linear <- as.vector(design[, -1, drop = FALSE] %*% free)
    -sum(won * log(cdf(linear)) + lost * log(cdf(-linear))) -
      as.numeric(determinant(information(linear)[-1, -1, drop = FALSE])$modulus) / 2
  }
  free <- rep(0, k - 1)
  for (again in 1:3) free <- optim(free, minus, method = "BFGS", control = list(reltol = 1e-16, maxit = 1e4, ndeps = rep(1e-6, k - 1)))$par
  values <- c(0, free) - mean(c(0, free))
  linear <- as.vector(design %*% values)
  p <- cdf(linear)
  slope <- pdf(linear)
  inverse <- function(m) {
    e <- eigen(m, symmetric = TRUE)
    some <- e$values > 1e-12 * max(e$values)
    e$vectors[, some] %*% (t(e$vectors[, some]) / e$values[some])
  }
  covariance <- inverse(information(linear))
  quantile <- qnorm((1 + confidence) / 2)
  if (people >= 3 && any(apply(chosen, 2:3, function(count) diff(range(count))) > 0)) {
    scores <- t(sapply(seq_len(people), function(i) {
      own <- matrix(chosen[i, , ], k)
      colSums(design * ((own[pairs] - (own + t(own))[pairs] * p) * slope / (p * (1 - p))))
    }))
    covariance <- covariance %*% (t(scores) %*% scores * people / (people - 1)) %*% covariance
    quantile <- qt((1 + confidence) / 2, people - 1)
  }
  half <- quantile * sqrt(pmax(diag(covariance), 0))
  out <- c(answers = sum(pooled), participants = people, setNames(values, paste0("values.", seq_len(k) - 1)),
           numbered("intervals.", Map(function(v, h) c("0" = v - h, "1" = v + h), values, half)))
  df <- length(one) - (k - 1)
  if (df < 1) return(out)
  gained <- function(count, p) ifelse(count > 0, count * log(count / n / p), 0)
  deviance <- 2 * sum(gained(won, p) + gained(lost, 1 - p))
  c(out, fit.deviance = deviance, fit.df = df, fit.p = pchisq(deviance, df, lower.tail = FALSE))
}

# Number of triads, and numbers of violations of weak, moderate and strong transitivity.
transitivity <- function(chosen) {
  pooled <- apply(chosen, 2:3, sum)
  n <- pooled + t(pooled)
  share <- pooled / ifelse(n > 0, n, 1)
  triads <- 0
  broken <- c(0, 0, 0)
  for (three in asplit(combn(nrow(pooled), 3), 2)) {
    if (any(n[three, three][upper.tri(diag(3))] == 0)) next
    triads <- triads + 1
    held <- c(FALSE, FALSE, FALSE)
    for (order in asplit(orders(3), 1)) {
      abc <- three[order]
      x <- share[abc[1], abc[2]]
      y <- share[abc[2], abc[3]]
      far <- share[abc[1], abc[3]]
      if (min(x, y) >= 0.5) held <- held | far >= c(0.5, min(x, y), max(x, y))
    }
    broken <- broken + !held
  }
  if (triads) c(triads = triads, setNames(broken, paste0(c("weak", "moderate", "strong"), "_violations")))
}

# Circular triads of one participant, Kendall's coefficient, and p (up to 6 surfaces) if every pair was
# compared an odd number of times. A score is the number of wins plus a binomial number of ties.
consistency <- function(chosen) {
  k <- nrow(chosen)
  up <- upper.tri(chosen)
  if (k < 3 || any((chosen + t(chosen))[up] == 0)) return(NULL)
  ties <- rowSums(chosen == t(chosen)) - 1
  circular_of <- function(score, ties) choose(k, 3) - sum(score^2 + ties / 4 - score) / 2
  circular <- circular_of(rowSums(chosen > t(chosen)) + ties / 2, ties)
  most <- (k^3 - (if (k %% 2) k else 4 * k)) / 24
  out <- c(circular_triads = circular, triads = choose(k, 3), zeta = 1 - circular / most, ties = sum(ties) / 2)
  if (k > 6 || any((chosen + t(chosen))[up] %% 2 == 0)) return(out)
  pairs <- which(up, arr.ind = TRUE)
  ways <- as.matrix(expand.grid(rep(list(1:2), nrow(pairs))))
  fewer <- apply(ways, 1, function(way) circular_of(tabulate(pairs[cbind(seq_along(way), way)], k), 0) <= circular)
  c(out, p = mean(fewer))
}

# Triads: a probit model of which step was larger (difference scaling).
difference_scale <- function(main, surfaces) {
  places <- sapply(1:3, function(i) match(main[[paste0("stimulus", i)]], surfaces))
  design <- matrix(0, nrow(main), length(surfaces))
  for (step in list(c(1, 2, -1), c(2, 3, 1))) for (end in 1:2) {
    at <- cbind(seq_len(nrow(main)), (if (end == 1) pmax else pmin)(places[, step[1]], places[, step[2]]))
    design[at] <- design[at] + step[3] * (if (end == 1) 1 else -1)
  }
  larger <- as.numeric(main$response == 2)
  fit <- suppressWarnings(glm.fit(design[, -1], larger, family = binomial("probit"), control = list(epsilon = 1e-13, maxit = 100)))
  scale <- c(0, fit$coefficients)
  c(noise = 1 / scale[[length(scale)]], log_likelihood = -fit$deviance / 2, answers = nrow(main),
    setNames(scale / scale[[length(scale)]], paste0("values.", seq_along(scale) - 1)))
}

scale_of <- function(rows, confidence) {
  main <- rows[!rows$catch, ]
  triads <- any(!is.na(main$stimulus3))
  columns <- paste0("stimulus", if (triads) 1:3 else 1:2)
  surfaces <- surfaces_in_order(unlist(main[columns]))
  people <- in_code_order(main$participant_id)
  out <- c(participants = length(people), answers = nrow(main), catch_trials = sum(rows$catch))
  if (triads) return(c(out, under("differences.", difference_scale(main, surfaces))))
  k <- length(surfaces)
  chosen <- array(0, c(length(people), k, k))
  first <- main$response == 1
  won <- match(ifelse(first, main$stimulus1, main$stimulus2), surfaces)
  lost <- match(ifelse(first, main$stimulus2, main$stimulus1), surfaces)
  counts <- table(factor(match(main$participant_id, people), seq_along(people)), factor(won, seq_len(k)), factor(lost, seq_len(k)))
  chosen[] <- counts
  pooled <- apply(chosen, 2:3, sum)
  c(out, setNames(rowSums(pooled), paste0("chosen.", seq_len(k) - 1)),
    setNames(rowSums(pooled) + colSums(pooled), paste0("compared.", seq_len(k) - 1)),
    under("bradley_terry.", pair_scale(chosen, "logit", confidence)), under("thurstone.", pair_scale(chosen, "probit", confidence)),
    under("transitivity.", transitivity(chosen)),
    unlist(lapply(seq_along(people), function(i) under(paste0("consistency.", people[i], "."), consistency(matrix(chosen[i, , ], k))))))
}

# Matches, ratings, ratios, productions ------------------------------------------------------------

matching_of <- function(rows, confidence) {
  turned <- rows[!rows$catch, ]
  caught <- rows[rows$catch, ]
  reference <- turned$reference_level[1]
  own <- tapply(turned$matched_level, turned$participant_id, mean)
  sides <- person_means(turned$matched_level, turned$participant_id, factor(turned$direction, c("ascending", "descending")))
  spread <- tapply(turned$matched_level, list(turned$participant_id, turned$direction), var)
  c(reference = reference, matches = nrow(turned), participants = length(own), mean = mean(own),
    variability = sqrt(mean(spread, na.rm = TRUE)), ascending = mean(sides[, 1], na.rm = TRUE),
    descending = mean(sides[, 2], na.rm = TRUE), catch_trials = nrow(caught),
    catch_error = mean(abs(caught$matched_level - reference)), felt_again = mean(turned$felt_again, na.rm = TRUE),
    under("bias.", mean_test(own - reference, confidence)), under("direction.", mean_test(sides[, 2] - sides[, 1], confidence)))
}

ends_of <- function(rows) if (all(is.na(rows$categories))) c(0, 100) else c(1, max(rows$categories, na.rm = TRUE))
within <- function(ends, possible) pmin(pmax(ends, possible[1]), possible[2])
ratings_of <- function(rows, confidence) {
  main <- rows[!rows$catch, ]
  caught <- rows[rows$catch, ]
  surfaces <- surfaces_in_order(main$surface)
  cells <- person_means(main$rating, main$participant_id, factor(main$surface, surfaces))
  plain <- surfaces %in% main$surface[!is.na(main$level)]
  steps <- unique(rows$resolution[!is.na(rows$resolution)])
  bounds <- ends_of(rows)
  each <- lapply(seq_along(surfaces), function(i) {
    own <- cells[!is.na(cells[, i]), i]
    there <- main$rating[main$surface == surfaces[i]]
    ends <- if (length(own) >= 3 && sd(own) > 0) within(mean_and_ends(own, confidence)[2:3], bounds) else c(NA, NA)
    c(participants = length(own), ratings = length(there), mean = mean(own), sd = sd(own),
      interval.0 = ends[1], interval.1 = ends[2], at_left = sum(there == bounds[1]), at_right = sum(there == bounds[2]))
  })
  c(participants = nrow(cells), answers = nrow(main), catch_trials = nrow(caught),
    catch_mean = if (nrow(caught)) mean(tapply(caught$rating, caught$participant_id, mean)) else NA,
    categories = if (bounds[1] == 1) bounds[2] else NA,
    resolution = if (length(steps) == 1) steps else NA, numbered("surfaces.", each), under("friedman.", friedman(cells)),
    under("page_trend.", page_trend(cells[, plain, drop = FALSE])), rating_pairs(cells, confidence, diff(bounds)),
    under("start_effect.", mean_test(start_slopes(main), confidence)))
}
rating_pairs <- function(cells, confidence, length_of_scale) {
  pairs <- lapply(asplit(combn(ncol(cells), 2), 2), function(pair) {
    d <- cells[, pair[2]] - cells[, pair[1]]
    d <- d[!is.na(d)]
    c(participants = length(d), p_wilcoxon = if (length(d) >= 3) signed_rank(d) else NA,
      under("difference.", mean_test(d, confidence, c(-1, 1) * length_of_scale)))
  })
  numbered("pairs.", pairs)
}
# Holm's correction across the pairs of all tasks, conditions or factors.
with_holm <- function(found) {
  p <- found[grepl("\\.p_wilcoxon$", names(found)) & !is.na(found)]
  c(found, setNames(p.adjust(p, "holm"), sub("p_wilcoxon$", "p_wilcoxon_holm", names(p))))
}

# Ratings at the levels of each factor, over the surfaces that a participant rated at every level.
rating_conditions <- function(rows, confidence) {
  main <- rows[!rows$catch, ]
  of_task <- main[["task of all conditions"]]
  if (is.null(of_task)) return(NULL)
  compared <- expand.grid(factor = grep("^factor: ", names(main), value = TRUE), task = in_code_order(of_task), stringsAsFactors = FALSE)
  with_holm(numbered("rating_conditions.", Filter(Negate(is.null), Map(function(column, task) {
    own <- main[of_task == task, ]
    labels <- numbers_first(own[[column]])
    if (length(labels) < 2) return(NULL)
    rated <- tapply(own$rating, list(own$participant_id, own$surface, factor(own[[column]], labels)), mean)
    cells <- round(t(apply(rated, 1, function(own) colMeans(whole_rows(own)))), 9)
    c(under("friedman.", friedman(cells)), rating_pairs(cells, confidence, diff(ends_of(own))))
  }, compared$factor, compared$task))))
}

# Slope of ratings on the starting position of the mark, within surfaces.
start_slopes <- function(main) {
  known <- main[!is.na(main$cursor_start), ]
  cell <- paste(known$participant_id, known$surface, sep = "\r")
  dx <- known$cursor_start - ave(known$cursor_start, cell)
  dy <- known$rating - ave(known$rating, cell)
  squares <- tapply(dx^2, known$participant_id, sum)
  (tapply(dx * dy, known$participant_id, sum) / squares)[squares > 0]
}

geometric_rows <- function(logs, confidence, counts, of, value) lapply(seq_len(ncol(logs)), function(i) {
  y <- logs[!is.na(logs[, i]), i]
  ends <- if (length(y) >= 3 && sd(y) > 0) exp(mean_and_ends(y, confidence)[2:3]) else c(NA, NA)
  setNames(c(as.numeric(colnames(logs)[i]), length(y), counts[[colnames(logs)[i]]], exp(mean(y)), ends),
           c(of, "participants", value[2], value[1], "interval.0", "interval.1"))
})
catch_mean <- function(value, who) if (length(value)) exp(mean(tapply(log(value), who, mean))) else NA

ratios_of <- function(rows, confidence) {
  main <- rows[!rows$catch, ]
  logs <- person_means(log(main$ratio), main$participant_id, main$comparison_level)
  c(standard = main$standard_level[1], participants = nrow(logs), answers = nrow(main), catch_trials = sum(rows$catch),
    catch_ratio = catch_mean(rows$ratio[rows$catch], rows$participant_id[rows$catch]),
    numbered("surfaces.", geometric_rows(logs, confidence, table(main$comparison_level), "comparison", c("ratio", "judgements"))),
    under("power_law.", power_law(logs, as.numeric(colnames(logs)), confidence)))
}

productions_of <- function(rows, confidence, exponents) {
  main <- rows[!rows$catch, ]
  logs <- person_means(log(main$produced_level), main$participant_id, main$number)
  own <- slopes(logs, as.numeric(colnames(logs)))
  slope <- mean_test(own, confidence)
  sides <- person_means(log(main$produced_level), main$participant_id, factor(main$began, c("low", "high")))
  out <- c(standard = rows$standard_level[1], modulus = rows$modulus[1], participants = nrow(logs), answers = nrow(main),
           catch_trials = sum(rows$catch), catch = catch_mean(rows$produced_level[rows$catch], rows$participant_id[rows$catch]),
           at_bounds = sum(main$bound %in% c("lowest", "highest")),
           numbered("numbers.", geometric_rows(logs, confidence, table(main$number), "number", c("level", "productions"))),
           under("slope.", slope), under("beginning.", mean_test(sides[, "high"] - sides[, "low"], confidence)))
  if (!is.null(slope) && slope[["mean"]] > 0) {
    out <- c(out, exponent = 1 / slope[["mean"]])
    if (slope[["ci.0"]] > 0) out <- c(out, exponent_interval.0 = 1 / slope[["ci.1"]], exponent_interval.1 = 1 / slope[["ci.0"]])
  }
  both <- intersect(names(own)[!is.na(own) & own > 0], names(exponents)[!is.na(exponents) & exponents > 0])
  production <- -log(own[both])
  estimation <- log(exponents[both])
  ratio <- mean_test(production - estimation, confidence)
  combined <- mean_test((production + estimation) / 2, confidence)
  if (is.null(ratio) || is.null(combined)) return(out)
  told <- function(name, t) setNames(exp(t[c("mean", "ci.0", "ci.1")]), paste0(name, c("", "_interval.0", "_interval.1")))
  c(out, under("both.", c(n = length(both), participants = length(intersect(names(own), names(exponents))), estimation = exp(mean(estimation)), production = exp(mean(production)),
                          told("ratio", ratio), told("combined", combined))))
}

# Same-different: d' of the differencing model, after the log-linear correction ---------------------

differencing <- function(yes, n, false, m) {
  hits <- (yes + n / (n + m)) / (n + 2 * n / (n + m))
  alarms <- (false + m / (n + m)) / (m + 2 * m / (n + m))
  # A d' is negative if there are fewer hits than false alarms.
  criterion <- function(alarms) -sqrt(2) * qnorm(alarms / 2)
  k <- criterion(min(hits, alarms))
  excess <- function(d) pnorm((d - k) / sqrt(2)) + pnorm((-d - k) / sqrt(2)) - max(hits, alarms)
  size <- if (abs(hits - alarms) < 1e-15) 0 else uniroot(excess, c(0, 20), tol = 1e-12)$root
  c(sign(hits - alarms) * size, criterion(alarms))
}
same_different_of <- function(rows, confidence) {
  main <- rows[!rows$catch, ]
  main$same <- main$first == main$second
  names_there <- numbers_first(c(main$first, main$second))
  pairs <- lapply(asplit(combn(names_there, 2), 2), function(pair) {
    own <- main[main$first %in% pair & main$second %in% pair, ]
    count <- function(of) tapply(own$different, list(own$participant_id, factor(own$same, c(FALSE, TRUE))), of)
    counts <- cbind(count(sum), count(length))[, c(1, 3, 2, 4), drop = FALSE]
    counts <- counts[complete.cases(counts), , drop = FALSE]
    if (!nrow(counts)) return(NULL)
    d_of <- function(count) differencing(count[1], count[2], count[3], count[4])
    total <- colSums(counts)
    c(participants = nrow(counts), setNames(total, c("different", "different_n", "same", "same_n")),
      setNames(d_of(total), c("d_prime", "criterion")),
      under("mean_d_prime.", mean_test(apply(counts, 1, d_of)[1, ], confidence)))
  })
  c(participants = length(unique(main$participant_id)), answers = nrow(main),
    numbered("pairs.", Filter(Negate(is.null), pairs)))
}

# Groups and sessions ------------------------------------------------------------------------------

shifted_f <- function(f, df1, df2, p) {
  if (pf(f, df1, df2) <= p) return(0)
  above <- max(f * df1, 1)
  while (pf(f, df1, df2, ncp = above) > p) above <- 1.5 * above
  uniroot(function(ncp) pf(f, df1, df2, ncp = ncp) - p, c(0, above), tol = 1e-10)$root
}
eta2 <- function(f, df1, df2, confidence, name) {
  ncp <- sapply(c(1 + confidence, 1 - confidence) / 2, function(p) shifted_f(f, df1, df2, p))
  setNames(c(f * df1 / (f * df1 + df2), ncp / (ncp + df1 + df2 + 1)), paste0(name, c("", "_ci.0", "_ci.1")))
}
effect <- function(f, df1, df2, epsilon, confidence) {
  df1 <- df1 * epsilon
  df2 <- df2 * epsilon
  c(F = f, df1 = df1, df2 = df2, p = pf(f, df1, df2, lower.tail = FALSE), eta2(f, df1, df2, confidence, "eta2_partial"))
}

welch <- function(values, group, confidence) {
  kept <- is.finite(values)
  own <- split(values[kept], group[kept])
  if (min(lengths(own)) < 3) return(NULL)
  test <- oneway.test(values ~ group, data.frame(values, group)[kept, ], var.equal = FALSE)
  equal <- oneway.test(values ~ group, data.frame(values, group)[kept, ], var.equal = TRUE)
  pairs <- lapply(asplit(combn(names(own), 2), 2), function(pair) {
    a <- own[[pair[1]]]
    b <- own[[pair[2]]]
    t <- t.test(a, b, conf.level = confidence)
    df <- length(a) + length(b) - 2
    unit <- sqrt(1 / length(a) + 1 / length(b))
    d <- (mean(a) - mean(b)) / sqrt(((length(a) - 1) * var(a) + (length(b) - 1) * var(b)) / df)
    hedges <- c(d, sapply(c(1 + confidence, 1 - confidence) / 2, function(p) noncentrality(d / unit, df, p)) * unit) * (1 - 3 / (4 * df - 1))
    c(difference = mean(a) - mean(b), ci.0 = t$conf.int[1], ci.1 = t$conf.int[2], t = unname(t$statistic),
      df = unname(t$parameter), p = t$p.value, setNames(hedges, paste0("hedges_g", c("", "_ci.0", "_ci.1"))))
  })
  holm <- p.adjust(sapply(pairs, `[[`, "p"), "holm")
  f <- unname(equal$statistic)
  df <- unname(equal$parameter)
  c(F = unname(test$statistic), df1 = unname(test$parameter[1]), df2 = unname(test$parameter[2]), p = test$p.value,
    eta2(f, df[1], df[2], confidence, "eta2"),
    numbered("groups.", lapply(own, function(x) {
      ends <- mean_and_ends(x, confidence)
      c(n = length(x), mean = ends[1], sd = sd(x), ci.0 = ends[2], ci.1 = ends[3])
    })),
    numbered("pairs.", Map(function(pair, p) c(pair, p_holm = p), pairs, holm)))
}

epsilon_of <- function(s) sum(diag(s))^2 / (ncol(s) * sum(s^2))
contrasts_of <- function(k) contr.helmert(k) %*% diag(1 / sqrt(colSums(contr.helmert(k)^2)), k - 1)

mixed_anova <- function(logs, group, confidence) {
  whole <- complete.cases(logs) & !is.na(group)
  v <- logs[whole, , drop = FALSE]
  group <- factor(group[whole])
  if (min(table(group)) < 3) return(NULL)
  n <- nrow(v)
  k <- ncol(v)
  g <- nlevels(group)
  means <- apply(v, 2, function(column) ave(column, group))
  own <- rowMeans(v)
  error_people <- k * sum((own - rowMeans(means))^2)
  left <- v - means - (own - rowMeans(means))
  error <- sum(left^2)
  # Weighted by participants, as in the classical table.
  interaction <- sum((means - rowMeans(means) - rep(colMeans(v), each = n) + mean(v))^2)
  s <- cov((v - means) %*% contrasts_of(k)) # within groups
  epsilon <- if (k > 2) epsilon_of(s) else 1
  df_people <- n - g
  df_error <- df_people * (k - 1)
  at <- function(squares, df, of, df_of, e) effect(squares / df / (of / df_of), df, df_of, e, confidence)
  c(under("group.", at(k * sum((rowMeans(means) - mean(v))^2), g - 1, error_people, df_people, 1)),
    under("of_level.", at(n * sum((colMeans(v) - mean(v))^2), k - 1, error, df_error, epsilon)),
    under("interaction.", at(interaction, (g - 1) * (k - 1), error, df_error, epsilon)), epsilon_gg = epsilon)
}

groups <- function(members, logs, levels, confidence) {
  group <- members$group[match(rownames(logs), members$participant_id)]
  sizes <- table(group)
  compared <- names(sizes)[sizes >= 3]
  if (length(compared) < 2) return(NULL)
  without <- sum(is.na(group))
  group[!group %in% compared] <- NA
  whole <- logs
  whole[!complete.cases(whole), ] <- NA
  c(setNames(as.vector(sizes[compared]), paste0("n.", compared)), without_group = without,
    under("exponents.", welch(slopes(logs, levels), group, confidence)), under("levels.", welch(rowMeans(whole), group, confidence)),
    under("anova.", mixed_anova(logs, group, confidence)))
}

two_way_anova <- function(trials, other, name, confidence) {
  cells <- tapply(trials$log, list(trials$who, trials$level, other), function(v) mean(v, na.rm = TRUE))
  v <- matrix(cells, dim(cells)[1])
  v <- v[complete.cases(v), , drop = FALSE]
  n <- nrow(v)
  k <- dim(cells)[2]
  s <- dim(cells)[3]
  if (n < 3 || k < 2 || s < 2) return(NULL)
  one <- list(of_level = contrasts_of(k), other = contrasts_of(s))
  flat <- function(m) m / sqrt(nrow(m))
  of <- list(kronecker(one$other, flat(matrix(1, k))), of_level = kronecker(flat(matrix(1, s)), one$of_level),
             interaction = kronecker(one$other, one$of_level))
  names(of)[1] <- name
  found <- unlist(lapply(names(of), function(name) {
    z <- v %*% of[[name]]
    df <- ncol(z)
    f <- n * sum(colMeans(z)^2) / df / (sum(sweep(z, 2, colMeans(z))^2) / (df * (n - 1)))
    under(paste0(name, "."), effect(f, df, df * (n - 1), epsilon_of(cov(z)), confidence))
  }))
  c(n = n, found)
}

# Factors crossed with the levels: means, analysis of variance, and changes from the first condition.
factor_effects <- function(trials, levels, confidence) {
  columns <- grep("^factor: ", names(trials), value = TRUE)
  columns <- columns[vapply(columns, function(name) length(unique(trials[[name]])) > 1, NA)]
  numbered("factors.", lapply(columns, function(column) {
    condition <- as.character(trials[[column]])
    labels <- numbers_first(condition)
    logs <- lapply(labels, function(label) {
      own <- trials[condition == label, ]
      tapply(own$log, list(factor(own$who, unique(trials$who)), factor(own$level, levels)), function(v) mean(v, na.rm = TRUE))
    })
    present <- sapply(labels, function(label) length(unique(trials$who[condition == label])))
    means <- Map(function(v, n) c(n = n, setNames(exp(colMeans(v, na.rm = TRUE)), paste0("geometric_means.", levels)), setNames(colSums(!is.na(v)), paste0("ns.", levels))), logs, present)
    mixed <- mixed_changes(trials, condition, sub("^factor: ", "", column), labels, confidence)
    slopes_of <- lapply(logs, slopes, levels)
    changes <- lapply(seq_along(labels)[-1], function(i) c(
      under("exponent.", mean_test(slopes_of[[i]] - slopes_of[[1]], confidence)),
      under("log_ratio.", mean_test(rowMeans(logs[[i]] - logs[[1]], na.rm = TRUE), confidence)),
      mixed$changes[[i - 1]]))
    for (what in c("exponent", "log_ratio")) {
      p <- sapply(changes, function(each) unname(each[paste0(what, ".p")]))
      changes <- Map(function(each, holm) c(each, setNames(holm, paste0(what, "_p_holm"))), changes, p.adjust(p, "holm"))
    }
    c(numbered("conditions.", means), under("anova.", two_way_anova(trials, condition, "factor", confidence)),
      mixed$fit, numbered("changes.", changes))
  }))
}

# Change in exponent, and in the logarithm at the mean log level, for each condition (mixed model).
mixed_changes <- function(trials, condition, column, labels, confidence) {
  d <- transform(trials, condition = factor(condition, labels))[trials$level > 0 & !is.na(trials$log), ]
  d$lx <- log(d$level) - mean(log(d$level))
  n <- length(unique(d$who))
  if (!requireNamespace("lme4", quietly = TRUE) || n < 3 || nrow(d) <= 2 * length(labels) * n) return(NULL)
  m <- suppressMessages(suppressWarnings(lme4::lmer(log ~ lx * condition + (lx + condition | who), d)))
  if (lme4::isSingular(m, tol = 1e-2)) cat("mixed model with factor", paste0(column, ":"), at_its_bound, "\n")
  se <- sqrt(diag(as.matrix(vcov(m))))
  names(se) <- names(lme4::fixef(m))
  changes <- lapply(labels[-1], function(label) {
    one <- function(name, term) {
      b <- lme4::fixef(m)[[term]]
      half <- qt((1 + confidence) / 2, n - 1) * se[[term]]
      under(paste0(name, "."), c(value = b, se = se[[term]], ci.0 = b - half, ci.1 = b + half, p = 2 * pt(-abs(b / se[[term]]), n - 1)))
    }
    c(one("mixed_exponent", paste0("lx:condition", label)), one("mixed_log_ratio", paste0("condition", label)))
  })
  list(fit = c(mixed.log_likelihood_reml = as.numeric(logLik(m))), changes = changes)
}

# Stress of a reported map, and participants' weights for its axes. The search for maps is not repeated,
# so coordinates, and the stress with other numbers of dimensions, are taken from the report.
similarity_of <- function(rows, place, sorted) {
  numbers <- read("numbers.csv")
  main <- rows[!rows$catch & rows$first != rows$second, ]
  items <- unique(c(main$first, main$second))
  at <- function(k) numbers$value[match(paste0(place, "coordinates.", items, ".", k), numbers$name)]
  map <- cbind(at(0), at(1))
  map <- map[, colSums(is.na(map)) == 0, drop = FALSE]
  if (!ncol(map)) return(NULL)
  table_of <- function(who) {
    own <- main[main$participant_id == who, ]
    pair <- function(one, other) list(factor(own[[one]], items), factor(own[[other]], items))
    of <- function(f) { v <- tapply(own$dissimilarity, pair("first", "second"), f); v[is.na(v)] <- 0; v + t(v) }
    v <- (of(sum) / of(length))[lower.tri(diag(length(items)))]
    if (sorted) v else v / sqrt(mean(v^2, na.rm = TRUE))
  }
  people <- in_code_order(main$participant_id)
  tables <- sapply(people, table_of)
  group <- rowMeans(tables, na.rm = TRUE)
  squares <- sapply(seq_len(ncol(map)), function(k) as.vector(dist(map[, k]))^2)
  distances <- sqrt(rowSums(squares))
  # Monotone regression in which equal dissimilarities may have different distances (primary ties).
  up <- order(round(group, 9), distances)
  fitted <- isoreg(distances[up])$yf
  squares <- squares / mean(rowSums(squares))
  weighed <- function(wanted) {
    if (anyNA(wanted)) return(NULL)
    sets <- list(seq_len(ncol(squares)), 1, ncol(squares))
    tries <- lapply(sets, function(set) replace(numeric(ncol(squares)), set, pmax(qr.coef(qr(squares[, set, drop = FALSE]), wanted), 0)))
    lost <- sapply(tries, function(w) sum((wanted - squares %*% w)^2))
    best <- tries[[which.min(lost)]]
    c(setNames(best, paste0("weights.", seq_along(best) - 1)), r2 = 1 - min(lost) / sum((wanted - mean(wanted))^2))
  }
  found <- if (sorted) list() else Filter(Negate(is.null), lapply(people, function(who) weighed(tables[, who]^2)))
  run <- paste(main$participant_id, main$session, main$run, sep = "\r")
  answers <- if (sorted) length(unique(paste(run, c(main$first, main$second), sep = "\r"))) else nrow(main)
  out <- c(participants = length(people), answers = answers, catch_trials = sum(rows$catch),
           stress = sqrt(sum((distances[up] - fitted)^2) / sum(distances^2)), numbered("people.", found))
  names(out)[names(out) == "stress"] <- paste0("stress.", ncol(map))
  out
}

# ICC(A,1), case 2A of McGraw and Wong.
absolute_agreement <- function(v, confidence) {
  n <- nrow(v)
  k <- ncol(v)
  left <- v - rowMeans(v) - rep(colMeans(v), each = n) + mean(v)
  between <- k * var(rowMeans(v))
  sessions <- n * var(colMeans(v))
  error <- sum(left^2) / ((n - 1) * (k - 1))
  value <- (between - error) / (between + (k - 1) * error + k / n * (sessions - error))
  a <- k * value / (n * (1 - value))
  b <- 1 + k * value * (n - 1) / (n * (1 - value))
  df <- (a * sessions + b * error)^2 / ((a * sessions)^2 / (k - 1) + (b * error)^2 / ((n - 1) * (k - 1)))
  low <- qf((1 + confidence) / 2, n - 1, df)
  high <- qf((1 + confidence) / 2, df, n - 1)
  rest <- k * sessions + (k * n - k - n) * error
  c(value = value, ci.0 = n * (between - low * error) / (low * rest + n * between),
    ci.1 = n * (high * between - error) / (rest + n * high * between))
}

session_measures <- function(measures, confidence) {
  places <- unique(measures$measure)
  labels <- unique(measures$session)
  found <- lapply(places, function(place) {
    own <- measures[measures$measure == place, ]
    v <- whole_rows(tapply(own$value, list(own$participant_id, factor(own$session, labels)), mean))
    if (!nrow(v)) return(c(n = 0))
    changes <- lapply(seq_along(labels)[-1], function(i) under("change.", mean_test(v[, i] - v[, 1], confidence)))
    c(n = nrow(v), setNames(colMeans(v), paste0("means.", seq_along(labels) - 1)), numbered("changes.", changes),
      if (nrow(v) >= 3) under("agreement.", absolute_agreement(v, confidence)))
  })
  found <- numbered("", found)
  p <- found[grepl("changes\\.\\d+\\.change\\.p$", names(found))]
  c(found, setNames(p.adjust(p, "holm"), sub("change\\.p$", "p_holm", names(p))))
}

# Everything ---------------------------------------------------------------------------------------

# Trials whose columns of levels have the same names in every quantity; settings.csv declares them.
trials_of <- function(name, settings) {
  rows <- read(name)
  if (is.null(rows)) return(NULL)
  columns <- c("level", "track_level", "standard_level", "reference_level", "matched_level", "comparison_level", "produced_level")
  there <- match(names(rows), settings[columns])
  names(rows)[!is.na(there)] <- columns[there[!is.na(there)]]
  rows
}

tasks <- function(settings, wanted, trials, logs) {
  confidence <- as.numeric(settings[["confidence"]])
  levels <- as.numeric(colnames(logs))
  exponents <- if (is.null(logs)) NULL else slopes(logs, levels)
  out <- NULL
  choices <- trials_of("trials_forced_choices.csv", settings)
  if (!is.null(choices)) {
    out <- thresholds(choices, confidence, settings)
    out <- c(out, agreement(choices, exponents, out, confidence))
  }
  each <- function(rows, keys) {
    main <- unique(rows[!rows$catch, keys, drop = FALSE])
    main <- main[do.call(order, c(list(padded(main$task)), unname(as.list(main)), method = "radix")), , drop = FALSE]
    lapply(seq_len(nrow(main)), function(i) rows[Reduce(`&`, lapply(keys, function(key) rows[[key]] == main[[key]][i])), ])
  }
  parts <- list(
    scales = list("trials_comparisons.csv", "task", function(rows) scale_of(rows, confidence)),
    matching = list("trials_matches.csv", c("task", "reference_level"), function(rows) matching_of(rows, confidence)),
    ratings = list("trials_ratings.csv", "task", function(rows) ratings_of(rows, confidence)),
    ratios = list("trials_ratios.csv", c("task", "standard_level"), function(rows) ratios_of(rows, confidence)),
    productions = list("trials_productions.csv", "task", function(rows) productions_of(rows, confidence, exponents)),
    same_different = list("trials_same_different.csv", "task", function(rows) same_different_of(rows, confidence)))
  for (name in names(parts)) {
    rows <- trials_of(parts[[name]][[1]], settings)
    if (!is.null(rows)) out <- c(out, with_holm(numbered(paste0(name, "."), lapply(each(rows, parts[[name]][[2]]), parts[[name]][[3]]))))
  }
  rows <- trials_of("trials_ratings.csv", settings)
  if (!is.null(rows)) out <- c(out, rating_conditions(rows, confidence))
  for (name in c("similarity", "sorting")) {
    rows <- read(if (name == "sorting") "trials_sorting.csv" else "trials_dissimilarities.csv")
    kinds <- if (is.null(rows)) list() else each(rows, "task")
    out <- c(out, unlist(lapply(seq_along(kinds), function(i) {
      place <- paste0(name, ".", i - 1, ".")
      under(place, similarity_of(kinds[[i]], place, name == "sorting"))
    })))
  }
  members <- read("groups.csv")
  if (!is.null(members) && !is.null(logs)) out <- c(out, under("groups.", groups(members, logs, levels, confidence)))
  measures <- read("session_measures.csv")
  if (!is.null(measures)) out <- c(out, under("sessions.measures.", session_measures(measures, confidence)))
  if (!is.null(trials) && length(unique(trials$session)) > 1) out <- c(out, under("sessions.anova.", two_way_anova(trials, trials$session, "session", confidence)))
  if (!is.null(trials)) out <- c(out, factor_effects(trials, levels, confidence))
  out
}
