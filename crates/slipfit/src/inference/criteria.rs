//! Decision thresholds with their meaning, source and effect, and the thresholds shared by all analyses.

/// A threshold that decides something in an analysis, as a row of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Criterion {
    /// Group and field, e.g. `window.rise_ratio`.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Quantity that is compared with it.
    pub meaning: &'static str,
    /// Where the value comes from.
    pub source: &'static str,
    /// Statistic of simulated or measured records that changes with the value.
    pub statistic: &'static str,
}

/// A number of either type, for the table.
pub(crate) trait Threshold: Copy {
    fn number(self) -> f64;
}

impl Threshold for f64 {
    fn number(self) -> f64 {
        self
    }
}

impl Threshold for usize {
    fn number(self) -> f64 {
        self as f64
    }
}

/// Declares a structure of thresholds: field, documentation and table row at once.
///
/// ```text
/// criteria! {
///     /// What the group decides.
///     pub struct WindowCriteria in "window" {
///         /// What is compared with it.
///         rise_ratio: f64 = 1.1, source "chosen by simulation", moves "window end";
///     }
/// }
/// ```
macro_rules! criteria {
    (
        $(#[$about:meta])*
        pub struct $name:ident in $group:literal {
            $(
                $(#[doc = $meaning:literal])+
                $field:ident: $type:ty = $value:expr, source $source:literal, moves $statistic:literal;
            )+
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq)]
        #[non_exhaustive]
        pub struct $name {
            $(
                $(#[doc = $meaning])+
                #[doc = ""]
                #[doc = concat!("Source: ", $source, ". Moves: ", $statistic, ".")]
                pub $field: $type,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $value,)+ }
            }
        }

        impl $name {
            /// Every threshold of the group with its meaning.
            pub fn table(&self) -> Vec<$crate::inference::criteria::Criterion> {
                use $crate::inference::criteria::{Criterion, Threshold};
                vec![$(
                    Criterion {
                        name: concat!($group, ".", stringify!($field)),
                        value: Threshold::number(self.$field),
                        meaning: concat!($($meaning),+).trim_start(),
                        source: $source,
                        statistic: $statistic,
                    },
                )+]
            }
        }
    };
}
pub(crate) use criteria;

/// Declares all thresholds of an analysis: its groups, in the order of its steps, and their common table.
macro_rules! criteria_groups {
    (
        $(#[$about:meta])*
        pub struct $name:ident {
            $( $(#[doc = $meaning:literal])+ $group:ident: $type:ty, )+
        }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Default)]
        #[non_exhaustive]
        pub struct $name {
            $( $(#[doc = $meaning])+ pub $group: $type, )+
        }

        impl $name {
            /// Every threshold with its value, meaning, source and effect, in the order of the steps.
            pub fn table(&self) -> Vec<$crate::inference::criteria::Criterion> {
                [$( self.$group.table(), )+].concat()
            }
        }
    };
}
pub(crate) use criteria_groups;

criteria! {
    /// Thresholds that every analysis shares.
    pub struct InferenceCriteria in "inference" {
        /// Standard errors by which a variance ratio or an autocorrelation of residuals must differ from its value
        /// under white noise to be taken into account.
        excess_significance: f64 = 1.6, source "two-sided 10 % point of the normal distribution",
            moves "coverage";
        /// Standard errors by which the variance of a loss between clusters of observations must exceed its value under
        /// white noise to be taken into account.
        cluster_significance: f64 = 2.6, source "one-sided 0.5 % point of the normal distribution",
            moves "coverage where noise changes along the decay";
        /// BIC decrease required before an instrument term (drift of the offset, drift of the frequency, a backbone) is
        /// added automatically.
        instrument_bic_margin: f64 = 14.0, source "leaves about one term in 1e5 to chance",
            moves "spread of the loss parameters in short records";
        /// Residuals beyond the noise, relative to the amplitude of a decay or the height of a curve, above which no
        /// law describes the data and nothing can be concluded about friction.
        no_law: f64 = 0.05, source "more than the terms of a law differ by",
            moves "the sentence of the answer, and false detections where the law is another";
        /// Number of standard errors above its value in the model without other losses up to which the data allow a
        /// loss.
        allowed_errors: f64 = 4.0, source "one value in 30000 by chance", moves "intervals of losses that are not determined";
        /// p value below which sliding friction counts as detected, if the BIC prefers it as well, and below which a
        /// purely viscous loss counts as excluded.
        detected: f64 = 0.01, source "one record in a hundred without friction",
            moves "false detections, and friction missed";
        /// p value below which a loss other than viscous and sliding may be part of the preferred model.
        further_significance: f64 = 0.005, source "one record in two hundred without drag",
            moves "drag chosen falsely, and missed";
        /// BIC difference by which a model with drag or a further loss but without viscous damping must be better:
        /// every oscillator has some loss linear in velocity, and an apparent absence is more often due to chance, with
        /// a friction that is far off.
        no_viscous_penalty: f64 = 6.0, source "strong evidence on the scale of Kass and Raftery (1995)",
            moves "bias of friction in records with two losses and 20 dB";
        /// Largest weak loss, as a fraction of the value that would replace all viscous loss.
        weak_loss: f64 = 0.05, source "chosen by simulation, drag of 2 to 100 % of the viscous loss at any quality factor",
            moves "coverage with weak drag, and width of intervals without drag";
        /// Prior odds that a loss absent from the model is a weak one, against a loss of any size.
        weak_loss_odds: f64 = 0.2, source "chosen with it", moves "coverage with weak drag, and width of intervals without drag";
        /// Excess of the sum of squares of a model over that of a larger one, in noise variances, above which it is not
        /// a rival and is fitted from one start to within a standard error.
        no_rival: f64 = 100.0, source "beyond every price of a parameter and every significance asked for",
            moves "time of analysis";
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_names_group_field_and_value() {
        let criteria = InferenceCriteria { excess_significance: 3.0, ..InferenceCriteria::default() };
        let table = criteria.table();
        assert_eq!(table[0].name, "inference.excess_significance");
        assert_eq!(table[0].value, 3.0);
        assert!(table[0].meaning.starts_with("Standard errors"), "{}", table[0].meaning);
        assert_eq!(table[1].value, 2.6);
    }
}
