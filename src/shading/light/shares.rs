//! Probabilities as integers, so that choices by integer random numbers have exactly these.

/// Splits `all` in proportion to `weights`, which are finite, not negative and not all 0. Weights
/// above 0 receive at least 1, others 0.
pub(super) fn shares(weights: &[f64], all: u64) -> Vec<u64> {
    let total: f64 = weights.iter().sum();
    let mut left = weights.iter().filter(|&&weight| weight > 0.0).count() as u64;
    let (mut sum, mut end) = (0.0, 0);
    let share = |&weight: &f64| {
        if weight <= 0.0 {
            return 0;
        }
        left -= 1;
        sum += weight;
        let begin = end;
        let wanted = (sum / total * all as f64).round() as u64;
        end = if left == 0 { all } else { wanted.clamp(begin + 1, all - left) };
        end - begin
    };
    weights.iter().map(share).collect()
}
