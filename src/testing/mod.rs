//! Support for unit tests.

pub mod random;

#[test]
fn neighbouring_seeds_share_no_numbers() {
    let numbers = |seed| {
        let mut random = random::Random::new(seed);
        (0..100).map(|_| random.unit().to_bits()).collect::<std::collections::BTreeSet<_>>()
    };
    for seed in 0..20 {
        assert!(numbers(seed).is_disjoint(&numbers(seed + 1)), "{seed}");
    }
}
