//! Tests that merging audits does not depend on order or grouping.

use proptest::prelude::*;
use trochoid_weights::Audit;

fn audit() -> impl Strategy<Value = Audit> {
    (0_u64..1000, 0_u64..1000, 0_u64..1000, 0.0_f64..1.0, 0.0_f64..1.0, 0.0_f64..1.0, 0_u64..10).prop_map(
        |(pixels, judged, hull_exits, worst_exit, weight_sum_max_deviation, weight_min, nan_count)| Audit {
            pixels,
            judged,
            hull_exits,
            worst_exit,
            weight_sum_max_deviation,
            weight_min,
            nan_count,
        },
    )
}

proptest! {
    #[test]
    fn merge_is_a_commutative_monoid(a in audit(), b in audit(), c in audit()) {
        prop_assert_eq!(a.merge(b), b.merge(a));
        prop_assert_eq!(a.merge(b).merge(c), a.merge(b.merge(c)));
        prop_assert_eq!(a.merge(Audit::default()), a);
    }
}
