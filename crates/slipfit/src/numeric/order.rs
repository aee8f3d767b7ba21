//! Sorting by a number: one sort routine, on indices, for all types.

/// Indices of the values in ascending order; the sort is stable.
pub(crate) fn ascending(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    order
}

/// Sorts a list by a number per element, in ascending order; the sort is stable.
///
/// The standard library's sort is compiled anew for every type, 7 kB each, and made up a tenth of the page's module.
pub(crate) fn sort_by_value<T>(list: &mut [T], value: impl Fn(&T) -> f64) {
    let values: Vec<f64> = list.iter().map(value).collect();
    let mut rank = vec![0; list.len()];
    for (place, index) in ascending(&values).into_iter().enumerate() {
        rank[index] = place;
    }
    for i in 0..list.len() {
        while rank[i] != i {
            let place = rank[i];
            list.swap(i, place);
            rank.swap(i, place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_list_is_sorted_as_the_library_sorts_it(numbers in prop::collection::vec(-4i8..4, 0..40)) {
            let mut list: Vec<(f64, usize)> = numbers.iter().map(|&n| f64::from(n)).zip(0..).collect();
            let mut expected = list.clone();
            sort_by_value(&mut list, |pair| pair.0);
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            prop_assert_eq!(list, expected);
        }
    }

    #[test]
    fn what_is_no_number_is_last() {
        let mut list = [f64::NAN, 2.0, f64::NEG_INFINITY, -0.0, 0.0];
        sort_by_value(&mut list, |v| *v);
        assert!(list[4].is_nan() && list[..4] == [f64::NEG_INFINITY, -0.0, 0.0, 2.0]);
        assert!(list[1].is_sign_negative());
    }
}
