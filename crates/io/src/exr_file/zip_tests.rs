use super::*;

#[test]
fn running_sums_of_eight_are_those_of_one_after_the_other() {
    for salt in 0..200_u64 {
        let mut seed = salt;
        let mut bytes = [0; 37];
        for byte in &mut bytes {
            seed = seed.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
            // Carries go wrong at extremes.
            *byte = [0, 0x7f, 0x80, 0xff, (seed >> 40) as u8][(seed >> 33) as usize % 5];
        }
        let mut last = ZERO;
        let expected: Vec<u8> = bytes
            .iter()
            .map(|byte| {
                last = sum(last, &[*byte]);
                last
            })
            .collect();
        let mut words = Words::new(&bytes[..36]);
        let mut out = [0; 18];
        let (a, b) = out.split_at_mut(salt as usize % 18);
        words.take(a);
        words.take(b);
        for (i, word) in out.iter().enumerate() {
            assert_eq!(word.to_le_bytes(), [expected[i], expected[18 + i]], "{salt}, word {i}");
        }
    }
}
