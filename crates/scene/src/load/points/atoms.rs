//! Colours and radii of chemical elements.
//!
//! Sources: the colours of Jmol; M. Mantina et al., "Consistent van der Waals radii for the whole
//! main group", J. Phys. Chem. A 113, 2009; A. Bondi, "Van der Waals volumes and radii", J. Phys.
//! Chem. 68, 1964, for the others; 2 where there is no measured radius.

use glam::Vec4;
use rotund_image::linear_from_srgb_table;

/// A chemical element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Atom {
    pub symbol: &'static str,
    /// The colour in sRGB, `0xrrggbb`.
    rgb: u32,
    /// Van der Waals radius in angstroms.
    pub radius: f32,
}

impl Atom {
    /// What stands for an atom of no known element.
    pub(super) const UNKNOWN: Self = Self { symbol: "X", rgb: 0xff_14_93, radius: 1.5 };

    /// Returns the linear colour.
    pub(super) fn color(self) -> Vec4 {
        let [_, r, g, b] = self.rgb.to_be_bytes();
        let [r, g, b] = [r, g, b].map(|byte| linear_from_srgb_table()[usize::from(byte)]);
        Vec4::new(r, g, b, 1.0)
    }
}

/// Returns the element of a symbol, such as `C`, `CL` or `c12`, or of an atomic number.
pub(super) fn find(word: &str) -> Option<Atom> {
    if let Ok(number) = word.parse::<usize>() {
        return number.checked_sub(1).and_then(|i| ATOMS.get(i)).copied();
    }
    let letters = letters(word);
    let same = |atom: &&Atom| atom.symbol.eq_ignore_ascii_case(letters);
    match ATOMS.iter().find(same) {
        None if matches!(letters, "D" | "T") => Some(ATOMS[0]),
        found => found.copied(),
    }
}

/// Returns the element of the first letter of a name of a force field, such as `OW` or `CT1`.
pub(super) fn find_by_first_letter(word: &str) -> Option<Atom> {
    letters(word).get(..1).and_then(find)
}

fn letters(word: &str) -> &str {
    &word[..word.bytes().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(word.len())]
}

const fn atom(symbol: &'static str, rgb: u32, radius: f32) -> Atom {
    Atom { symbol, rgb, radius }
}

/// By atomic number, from 1.
#[rustfmt::skip]
const ATOMS: [Atom; 109] = [
    atom("H", 0xff_ff_ff, 1.1), atom("He", 0xd9_ff_ff, 1.4), atom("Li", 0xcc_80_ff, 1.81),
    atom("Be", 0xc2_ff_00, 1.53), atom("B", 0xff_b5_b5, 1.92), atom("C", 0x90_90_90, 1.7),
    atom("N", 0x30_50_f8, 1.55), atom("O", 0xff_0d_0d, 1.52), atom("F", 0x90_e0_50, 1.47),
    atom("Ne", 0xb3_e3_f5, 1.54), atom("Na", 0xab_5c_f2, 2.27), atom("Mg", 0x8a_ff_00, 1.73),
    atom("Al", 0xbf_a6_a6, 1.84), atom("Si", 0xf0_c8_a0, 2.1), atom("P", 0xff_80_00, 1.8),
    atom("S", 0xff_ff_30, 1.8), atom("Cl", 0x1f_f0_1f, 1.75), atom("Ar", 0x80_d1_e3, 1.88),
    atom("K", 0x8f_40_d4, 2.75), atom("Ca", 0x3d_ff_00, 2.31), atom("Sc", 0xe6_e6_e6, 2.0),
    atom("Ti", 0xbf_c2_c7, 2.0), atom("V", 0xa6_a6_ab, 2.0), atom("Cr", 0x8a_99_c7, 2.0),
    atom("Mn", 0x9c_7a_c7, 2.0), atom("Fe", 0xe0_66_33, 2.0), atom("Co", 0xf0_90_a0, 2.0),
    atom("Ni", 0x50_d0_50, 1.63), atom("Cu", 0xc8_80_33, 1.4), atom("Zn", 0x7d_80_b0, 1.39),
    atom("Ga", 0xc2_8f_8f, 1.87), atom("Ge", 0x66_8f_8f, 2.11), atom("As", 0xbd_80_e3, 1.85),
    atom("Se", 0xff_a1_00, 1.9), atom("Br", 0xa6_29_29, 1.83), atom("Kr", 0x5c_b8_d1, 2.02),
    atom("Rb", 0x70_2e_b0, 3.03), atom("Sr", 0x00_ff_00, 2.49), atom("Y", 0x94_ff_ff, 2.0),
    atom("Zr", 0x94_e0_e0, 2.0), atom("Nb", 0x73_c2_c9, 2.0), atom("Mo", 0x54_b5_b5, 2.0),
    atom("Tc", 0x3b_9e_9e, 2.0), atom("Ru", 0x24_8f_8f, 2.0), atom("Rh", 0x0a_7d_8c, 2.0),
    atom("Pd", 0x00_69_85, 1.63), atom("Ag", 0xc0_c0_c0, 1.72), atom("Cd", 0xff_d9_8f, 1.58),
    atom("In", 0xa6_75_73, 1.93), atom("Sn", 0x66_80_80, 2.17), atom("Sb", 0x9e_63_b5, 2.06),
    atom("Te", 0xd4_7a_00, 2.06), atom("I", 0x94_00_94, 1.98), atom("Xe", 0x42_9e_b0, 2.16),
    atom("Cs", 0x57_17_8f, 3.43), atom("Ba", 0x00_c9_00, 2.68), atom("La", 0x70_d4_ff, 2.0),
    atom("Ce", 0xff_ff_c7, 2.0), atom("Pr", 0xd9_ff_c7, 2.0), atom("Nd", 0xc7_ff_c7, 2.0),
    atom("Pm", 0xa3_ff_c7, 2.0), atom("Sm", 0x8f_ff_c7, 2.0), atom("Eu", 0x61_ff_c7, 2.0),
    atom("Gd", 0x45_ff_c7, 2.0), atom("Tb", 0x30_ff_c7, 2.0), atom("Dy", 0x1f_ff_c7, 2.0),
    atom("Ho", 0x00_ff_9c, 2.0), atom("Er", 0x00_e6_75, 2.0), atom("Tm", 0x00_d4_52, 2.0),
    atom("Yb", 0x00_bf_38, 2.0), atom("Lu", 0x00_ab_24, 2.0), atom("Hf", 0x4d_c2_ff, 2.0),
    atom("Ta", 0x4d_a6_ff, 2.0), atom("W", 0x21_94_d6, 2.0), atom("Re", 0x26_7d_ab, 2.0),
    atom("Os", 0x26_66_96, 2.0), atom("Ir", 0x17_54_87, 2.0), atom("Pt", 0xd0_d0_e0, 1.75),
    atom("Au", 0xff_d1_23, 1.66), atom("Hg", 0xb8_b8_d0, 1.55), atom("Tl", 0xa6_54_4d, 1.96),
    atom("Pb", 0x57_59_61, 2.02), atom("Bi", 0x9e_4f_b5, 2.07), atom("Po", 0xab_5c_00, 1.97),
    atom("At", 0x75_4f_45, 2.02), atom("Rn", 0x42_82_96, 2.2), atom("Fr", 0x42_00_66, 3.48),
    atom("Ra", 0x00_7d_00, 2.83), atom("Ac", 0x70_ab_fa, 2.0), atom("Th", 0x00_ba_ff, 2.0),
    atom("Pa", 0x00_a1_ff, 2.0), atom("U", 0x00_8f_ff, 1.86), atom("Np", 0x00_80_ff, 2.0),
    atom("Pu", 0x00_6b_ff, 2.0), atom("Am", 0x54_5c_f2, 2.0), atom("Cm", 0x78_5c_e3, 2.0),
    atom("Bk", 0x8a_4f_e3, 2.0), atom("Cf", 0xa1_36_d4, 2.0), atom("Es", 0xb3_1f_d4, 2.0),
    atom("Fm", 0xb3_1f_ba, 2.0), atom("Md", 0xb3_0d_a6, 2.0), atom("No", 0xbd_0d_87, 2.0),
    atom("Lr", 0xc7_00_66, 2.0), atom("Rf", 0xcc_00_59, 2.0), atom("Db", 0xd1_00_4f, 2.0),
    atom("Sg", 0xd9_00_45, 2.0), atom("Bh", 0xe0_00_38, 2.0), atom("Hs", 0xe6_00_2e, 2.0),
    atom("Mt", 0xeb_00_26, 2.0),
];
