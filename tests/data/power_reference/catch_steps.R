# Catch steps of the descending difference, written once more in base R: how often a step is felt, and
# the interval of the share of "yes" at catch steps.   Rscript catch_steps.R > catch_steps.csv   (R 4.2.2)
# The model: experiments/participants/simulated_people/respondent.py (`notices`), without lapses and dropout. The
# interval: Clopper and Pearson's of as many answers as there would be independent ones (Korn and
# Graubard 1998, Surv. Methodol. 24, 193-201), the design effect corrected by Student's t.
set.seed(1998)
mu <- c(12.75, 19.58, 56.25, 81.33)
changes <- rev(diff(mu))
threshold_sigma <- 0.25; criterion <- 1.6; criterion_sd <- 0.3

half_width <- function(yes, answers) {
  n <- length(yes); total <- sum(answers); share <- sum(yes) / total
  effective <- if (total == n) total else n
  if (total != n && share > 0 && share < 1) {
    left <- yes - share * answers
    alike <- max(n / (n - 1) * sum(left^2) / total^2 / (share * (1 - share) / total), 1)
    few <- qt(0.025, total - 1) / qt(0.025, n - 1)
    effective <- min(total / alike * few^2, total)
  }
  x <- share * effective
  low <- if (x <= 0) 0 else qbeta(0.025, x, effective - x + 1)
  high <- if (x >= effective) 1 else qbeta(0.975, x + 1, effective - x)
  (high - low) / 2
}

cat("participants,noise,catch_steps,studies,felt_1,felt_2,felt_3,felt_catch,half_width,error\n")
studies <- 2000
for (case in list(c(12, 9, 1), c(12, 9, 3), c(8, 9, 6), c(24, 2.2, 2))) {
  n <- case[1]; catches <- case[3]
  found <- replicate(studies, {
    own <- case[2] * exp(threshold_sigma * rnorm(n))
    c_own <- criterion + criterion_sd * rnorm(n)
    felt <- sapply(changes, function(x) mean(x / own + rnorm(n) > c_own))
    yes <- rowSums(matrix(rnorm(n * catches) > c_own, n))
    c(felt, sum(yes) / (n * catches), half_width(yes, rep(catches, n)))
  })
  cat(paste(c(case, studies, rowMeans(found), sd(found[5, ]) / sqrt(studies)), collapse = ","), "\n", sep = "")
}
