# Writes the psychophysical tables beside this script, and R's own figures of them:
# Rscript make_psychophysics.R
# R 4.2.2, lme4 1.1-31, geepack 1.3.9, BradleyTerry2 1.1-2, MASS 7.3-58, alr4 1.0.7, MPDiR 0.2.
# Sources and licences: README.md.
library(geepack)
library(lme4)
data(Stevens, package = "alr4")
data(HSP, Context, package = "MPDiR")
data(OME, package = "MASS")
data(sound.fields, package = "BradleyTerry2")

# Decibels to sound pressure: 20 µPa is 0 dB.
pressure <- function(db) signif(20 * 10^(db / 20), 7)

# A row an answer, from counts.
answers <- function(d, yes, n, names) {
  rows <- rep(seq_len(nrow(d)), n)
  out <- d[rows, names, drop = FALSE]
  out$answer <- unlist(Map(function(k, m) rep(c("yes", "no"), c(k, m - k)), yes, n))
  rownames(out) <- NULL
  out
}
write <- function(d, name) write.csv(d, paste0(name, ".csv"), row.names = FALSE, quote = FALSE)

# Magnitude: the length of a line drawn as long as a tone is loud.
loudness <- data.frame(subject = Stevens$subject, sound_pressure = pressure(Stevens$loudness),
                       length = signif(exp(Stevens$y), 7))
write(loudness, "loudness")
lx <- log(loudness$sound_pressure)
ly <- log(loudness$length)
slopes <- sapply(split(data.frame(lx, ly), loudness$subject), function(s) coef(lm(ly ~ lx, s))[[2]])
interval <- t.test(slopes)$conf.int
ranks <- friedman.test(loudness$length, factor(loudness$sound_pressure), loudness$subject)
long <- data.frame(l = ly, s = loudness$subject, a = factor(loudness$sound_pressure))
f <- summary(aov(l ~ a + Error(s / a), long))[["Error: s:a"]][[1]]["a", "F value"]
old <- read.csv("r_figures.csv", strip.white = TRUE)
old <- old[old$table != "loudness", ]
new <- data.frame(table = "loudness", participants = 10, exponent = mean(slopes),
                  low = interval[1], high = interval[2], friedman_chi2 = unname(ranks$statistic), F = f)
write.csv(format(rbind(old, new), digits = 12), "r_figures.csv", row.names = FALSE, quote = FALSE)

# Yes and no.
seen <- answers(data.frame(observer = HSP$Obs, run = sub("R", "", HSP$Run), quanta = HSP$Q),
                round(HSP$p * HSP$N / 100), HSP$N, c("observer", "run", "quanta"))
write(seen, "flashes")
bars <- answers(data.frame(observer = Context$Obs, context = Context$ContCntr,
                           contrast = Context$TargCntr),
                Context$NumYes, Context$NumYes + Context$NumNo,
                c("observer", "context", "contrast"))
write(bars, "contrast")
# Forced choice: whether the side of the sound was told.
OME <- OME[OME$Noise == "coherent", ]
ears <- answers(data.frame(child = paste0("c", OME$ID), sound_pressure = pressure(OME$Loud)),
                OME$Correct, OME$Trials, c("child", "sound_pressure"))
write(ears, "hearing")
tables <- list(flashes = list(seen, "observer", "quanta"),
               contrast = list(bars[bars$context == 0, ], "observer", "contrast"),
               hearing = list(ears, "child", "sound_pressure"))
rows <- NULL
for (name in names(tables)) {
  d <- tables[[name]][[1]]
  d <- data.frame(who = factor(d[[tables[[name]][[2]]]]), x = d[[tables[[name]][[3]]]],
                  yes = as.integer(d$answer == "yes"))
  d <- d[order(d$who), ]
  # In units of the largest, which geepack's steps need.
  top <- max(d$x)
  d$z <- d$x / top
  # Of the children's answers the fit runs away in geepack as in statsmodels: no figures.
  diverges <- name == "hearing"
  gee <- geeglm(yes ~ z, family = binomial, data = d, id = who, corstr = "exchangeable",
                control = geese.control(epsilon = 1e-10, maxit = 500))
  part <- data.frame(table = name, participants = nlevels(d$who), answers = nrow(d),
                     yes = sum(d$yes), intercept = coef(gee)[[1]], slope = coef(gee)[[2]] / top,
                     largest_d_prime = NA)
  if (diverges) part$intercept <- part$slope <- NA
  if (any(d$x == 0)) {
    probit <- glmer(yes ~ factor(x) + (1 | who), d, binomial("probit"), nAGQ = 25,
                    control = glmerControl("bobyqa", tolPwrss = 1e-10))
    part$largest_d_prime <- tail(fixef(probit), 1)[[1]]
  }
  rows <- rbind(rows, part)
}
write.csv(format(rows, digits = 12), "r_figures_yes_no.csv", row.names = FALSE, quote = FALSE)

# Paired comparisons: which of two sound fields was preferred.
pairs <- with(sound.fields$comparisons, data.frame(
  chosen = c(as.character(field1), as.character(field2)),
  other = c(as.character(field2), as.character(field1)), times = c(win1, win2)))
pairs <- aggregate(times ~ chosen + other, pairs, sum)
write(pairs, "sound_fields")
names <- sort(unique(pairs$chosen))
both <- merge(pairs, pairs, by.x = c("chosen", "other"), by.y = c("other", "chosen"))
both <- both[as.character(both$chosen) < as.character(both$other), ]
x <- sapply(names, function(n) (both$chosen == n) - (both$other == n))
# Firth's: the likelihood times the square root of the information's determinant.
minus <- function(b) {
  z <- drop(x[, -1] %*% b)
  information <- crossprod(x[, -1], (both$times.x + both$times.y) * dlogis(z) * x[, -1])
  -sum(both$times.x * plogis(z, log.p = TRUE) + both$times.y * plogis(-z, log.p = TRUE)) -
    as.numeric(determinant(information)$modulus) / 2
}
b <- rep(0, length(names) - 1)
for (again in 1:4) b <- optim(b, minus, method = "BFGS",
                              control = list(reltol = 1e-16, maxit = 1e4, ndeps = rep(1e-6, length(b))))$par
scale <- c(0, b) - mean(c(0, b))
write.csv(data.frame(field = names, scale = format(scale, digits = 12)), "r_figures_pairs.csv",
          row.names = FALSE, quote = FALSE)
