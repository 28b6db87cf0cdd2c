//! Rays at a bilinear patch whose crossing depends on digits that an `f64` does not have.
//!
//! They were found among a million random rays by their errors. The exact crossings were computed
//! with 106 bits.

mod support;

use rotund_geometry::glam::{DVec3, Vec3};
use rotund_geometry::{BilinearPatch, Ray};
use support::degrees;

struct Case {
    why: &'static str,
    /// `p00`, `p10`, `p01`, `p11`, the origin and the direction, to the last bit.
    bits: [[u32; 3]; 6],
    t_min: f32,
    /// `t` and the normal of the first crossing.
    expected: (f64, [f64; 3]),
}

#[rustfmt::skip]
fn cases() -> Vec<Case> {
    vec![
        Case {
            why: "two roots of nearly the same u, one next to the origin",
            bits: [
                [0x3f27_a5f7, 0xbf40_deab, 0xbe81_9ce0],
                [0x3ec8_172a, 0xbeb4_51a9, 0xbf71_5bf0],
                [0xbf17_877e, 0xbe8a_2e52, 0xbf04_8b00],
                [0xbea0_3189, 0xbf81_8768, 0xbdfd_30f3],
                [0xbeb1_4e3e, 0xbf68_efef, 0xbe38_3541],
                [0x3f2d_6c56, 0x3ee2_4817, 0xbf16_87eb],
            ],
            t_min: 1e-4,
            expected: (0.0012254647648015412, [-0.328_140_300, -0.533_853_445, -0.779_310_236]),
        },
        Case {
            why: "grazes next to a ruling, which is nearly parallel to the ray",
            bits: [
                [0xbb2d_52cc, 0xbea8_3415, 0xbf0a_5874],
                [0xbf5c_dd79, 0xbcf7_c2e0, 0x3ea2_b0dc],
                [0x3e4d_cd1d, 0x3f3f_cfb5, 0xbca1_5dd9],
                [0x3e57_b958, 0xbe93_37f8, 0x3f2d_0cd1],
                [0xc04b_7487, 0xbed2_b774, 0xbf90_5925],
                [0x3f65_b250, 0x3dd9_a5ff, 0x3edb_694b],
            ],
            t_min: 0.0,
            expected: (2.99353923916894, [-0.052_290_908, 0.989_346_617, -0.135_863_654]),
        },
        Case {
            why: "passes exactly through a corner, which belongs to the patch",
            bits: [
                [0xbf9b_7b32, 0xbec3_03b0, 0xbedb_b6a0],
                [0xbfef_ea69, 0x3f0d_d3db, 0xbf2e_63ce],
                [0xbf86_c274, 0xbe93_90cf, 0xbfc0_ed45],
                [0xbf49_0e38, 0x3f4f_d8b4, 0xbf80_d825],
                [0x3f2d_9ea2, 0x3fcd_dcb0, 0x3f47_7a3c],
                [0xbf21_8702, 0xbf29_be68, 0xbece_3908],
            ],
            t_min: 0.0,
            expected: (3.0, [-0.783_281_263, -0.598_243_853, -0.169_040_688]),
        },
        Case {
            why: "two roots of nearly the same u, but of different v",
            bits: [
                [0x3fe2_a895, 0xbf8d_fec2, 0xbe45_194f],
                [0x3f79_578d, 0xbfd7_ac98, 0xbe98_b606],
                [0x3ebe_cfbf, 0xbf6e_5645, 0xbed2_e472],
                [0x3f73_f0ce, 0xbee5_2200, 0x3e22_380e],
                [0x3f6e_57d1, 0xbf7d_f4a2, 0xbe8f_8201],
                [0x3f75_5aaa, 0xbe89_a38c, 0x3dc4_28a7],
            ],
            t_min: 1e-4,
            expected: (0.0013728909251571214, [-0.284_004_447, -0.931_525_986, 0.227_158_122]),
        },
        Case {
            why: "two crossings that round to the same t, far away",
            bits: [
                [0xbe22_248e, 0x3fdf_b3f6, 0x3e16_5c89],
                [0xbee0_00b7, 0x3fb4_a8d5, 0x3f96_520b],
                [0x3f24_a519, 0x3f90_6182, 0x3f05_c307],
                [0xbd3f_2aed, 0x3ed9_1545, 0x3f78_1143],
                [0x4b48_26e0, 0xc916_2065, 0xcadd_4075],
                [0xbf5f_ddb6, 0x3d27_e9fd, 0x3ef7_7749],
            ],
            t_min: 0.0,
            expected: (1.499_999_953_717_447_4e7, [0.067_652_555, 0.553_503_709, 0.830_094_438]),
        },
        Case {
            why: "two crossings that round to the same t, of opposite normals",
            bits: [
                [0x3e9e_90c6, 0xbee1_6999, 0xbf78_8633],
                [0xbce8_3b68, 0x3df1_9d98, 0xbff2_0443],
                [0xbf6c_9495, 0x3e16_698b, 0xbf94_a6e5],
                [0xbeec_0119, 0xbeba_12b8, 0xbee9_dd09],
                [0xbfa2_2eac, 0x4025_8b20, 0xbff5_b4f9],
                [0x3eaa_9871, 0xbf67_e8b9, 0x3e85_d7c8],
            ],
            t_min: 0.0,
            expected: (2.9999998159884833, [0.345_657_279, 0.853_161_291, 0.390_687_671]),
        },
        Case {
            why: "grazes at a larger angle",
            bits: [
                [0xbf28_9135, 0x3f53_3337, 0xbec8_12ae],
                [0xbe7f_a262, 0x3f96_e81e, 0x3f3e_4983],
                [0xbfbf_dc3a, 0x3fb3_8c1f, 0x3e70_e232],
                [0xbf16_1108, 0x4003_4d59, 0xbe02_5b62],
                [0xc03b_1860, 0x404a_1c9a, 0x3f24_9339],
                [0x3f36_2588, 0xbf2b_3725, 0xbe5c_afaa],
            ],
            t_min: 0.0,
            expected: (2.9909238487585306, [-0.316_294_014, -0.578_713_725, 0.751_697_094]),
        },
        Case {
            why: "grazes far away, where the image keeps few digits of the products that it is made of",
            bits: [
                [0xbeb2_f56c, 0x3eab_2b40, 0x3d40_142c],
                [0xbf63_4da7, 0xbdc2_707f, 0x3f94_0277],
                [0xbf91_235f, 0x3fa7_8222, 0x3f19_4133],
                [0xbdc3_31be, 0x3f53_4bad, 0x3fb0_c98b],
                [0x48f1_ebc7, 0x4949_42d3, 0x4885_aca0],
                [0xbefd_ac44, 0xbf53_0996, 0xbe8c_2aca],
            ],
            t_min: 0.0,
            expected: (999_999.947_636_279_7, [-0.867_185_463, 0.487_525_213, 0.101_530_981]),
        },
    ]
}

/// Returns every order of the corners with the same surface, and the sign by which it changes the
/// normal.
fn orders([p00, p10, p01, p11]: [Vec3; 4]) -> [(BilinearPatch, f64); 8] {
    let patch =
        |[p00, p10, p01, p11]: [Vec3; 4], side| (BilinearPatch { p00, p10, p01, p11 }, side);
    [
        patch([p00, p10, p01, p11], 1.0),
        patch([p10, p11, p00, p01], 1.0),
        patch([p11, p01, p10, p00], 1.0),
        patch([p01, p00, p11, p10], 1.0),
        patch([p00, p01, p10, p11], -1.0),
        patch([p10, p00, p11, p01], -1.0),
        patch([p11, p10, p01, p00], -1.0),
        patch([p01, p11, p00, p10], -1.0),
    ]
}

#[test]
fn folds_corners_and_origins_near_the_surface_do_not_reduce_the_accuracy() {
    for Case { why, bits, t_min, expected } in cases() {
        let [p00, p10, p01, p11, origin, direction] =
            bits.map(|p| Vec3::from(p.map(f32::from_bits)));
        let ray = Ray { t_min, ..Ray::new(origin, direction) };
        for (patch, side) in orders([p00, p10, p01, p11]) {
            let hit = patch.closest(&ray);
            assert_eq!(hit.map(|hit| hit.t), patch.closest_t(&ray), "{why}");
            let (hit, (t, normal)) = (hit.expect(why), expected);
            let off = (f64::from(hit.t) - t).abs() / (t * 2.0_f64.powi(-24));
            assert!(off <= 1.0, "{why}: t is {off} u off");
            let off = degrees(hit.normal, side * DVec3::from(normal));
            assert!(off <= 2e-5, "{why}: the normal is {off} degrees off");
        }
    }
}
