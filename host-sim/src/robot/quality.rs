//! The quality of a run: \[004\] eq. 17 to 19.

/// One control step, as the quality rates need it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// `e_t`: the distance to the goal, in metres.
    pub distance_m: f64,
    /// `v_t`: the robot's speed, in m/s.
    pub speed_m_s: f64,
}

/// The quality rates of \[004\] §4; smaller is better, except for the mean speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// E of eq. 17: Σ e² Δt, in m² s.
    pub error: f64,
    /// S of eq. 18: the standard deviation of the speed, in m/s; 0 for a single step.
    pub speed_deviation: f64,
    /// s of eq. 19: Σ v Δt, in metres; `None` if the goal was not reached, for which \[004\] writes +∞.
    pub route_m: Option<f64>,
    /// T: the duration, in seconds; `None` if the goal was not reached.
    pub time_s: Option<f64>,
    /// `v_M`: the mean speed, in m/s.
    pub mean_speed: f64,
}

impl Quality {
    /// Rates a run of `samples`, one every `step_s` seconds; `reached` is whether it reached its goal.
    ///
    /// ```
    /// use certainty_sim::robot::quality::{Quality, Sample};
    ///
    /// let sample = |distance_m, speed_m_s| Sample { distance_m, speed_m_s };
    /// let run = [sample(3.0, 0.5), sample(2.0, 1.5), sample(1.0, 1.0)];
    /// let quality = Quality::of(&run, 0.5, true);
    /// assert_eq!(quality.error, 7.0); // (9 + 4 + 1) / 2
    /// assert_eq!(quality.speed_deviation, 0.5); // √((0.25 + 0.25 + 0) / 2)
    /// assert_eq!(quality.route_m, Some(1.5));
    /// assert_eq!(quality.time_s, Some(1.5));
    /// assert_eq!(quality.mean_speed, 1.0);
    /// ```
    #[must_use]
    pub fn of(samples: &[Sample], step_s: f64, reached: bool) -> Self {
        let count = samples.len().max(1) as f64;
        let sum = |value: &dyn Fn(&Sample) -> f64| samples.iter().map(value).sum::<f64>();
        let mean_speed = sum(&|sample| sample.speed_m_s) / count;
        let squares = sum(&|sample| (sample.speed_m_s - mean_speed).powi(2));
        Self {
            error: sum(&|sample| sample.distance_m * sample.distance_m) * step_s,
            speed_deviation: (squares / (count - 1.0).max(1.0)).sqrt(),
            route_m: reached.then(|| sum(&|sample| sample.speed_m_s) * step_s),
            time_s: reached.then_some(samples.len() as f64 * step_s),
            mean_speed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_not_reached_has_no_route_and_no_time() {
        let sample = Sample {
            distance_m: 2.0,
            speed_m_s: 0.0,
        };
        let quality = Quality::of(&[sample; 4], 0.25, false);
        assert_eq!((quality.route_m, quality.time_s), (None, None));
        assert_eq!(
            (quality.error, quality.speed_deviation, quality.mean_speed),
            (4.0, 0.0, 0.0)
        );
    }
}
