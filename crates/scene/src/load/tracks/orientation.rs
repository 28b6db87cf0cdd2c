//! The directions in the head of the axes of a TRK file.

use glam::{DAffine3, DMat3, DVec3};

/// For each axis of an image, the axis of space along which it runs (0 to the right, 1 to the
/// front, 2 up), and whether it runs backwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Orientation([(usize, bool); 3]);

/// All orders of three axes.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

impl Orientation {
    /// The convention of TrackVis for files that do not say: to the left, to the back, up.
    pub(super) const LPS: Self = Self([(0, true), (1, true), (2, false)]);

    /// Parses three letters, as in `RAS`: where the axes run to. `None` unless they name three
    /// axes.
    pub(super) fn parse(letters: &[u8]) -> Option<Self> {
        let axis = |letter: &u8| {
            Some(match letter.to_ascii_uppercase() {
                b'R' => (0, false),
                b'L' => (0, true),
                b'A' => (1, false),
                b'P' => (1, true),
                b'S' => (2, false),
                b'I' => (2, true),
                _ => return None,
            })
        };
        let &[a, b, c] = letters else { return None };
        let axes = [axis(&a)?, axis(&b)?, axis(&c)?];
        ORDERS.contains(&axes.map(|(axis, _)| axis)).then_some(Self(axes))
    }

    /// Returns the nearest orientation of the axes of a matrix.
    pub(super) fn nearest(matrix: DMat3) -> Self {
        let columns = matrix.to_cols_array_2d().map(|column| DVec3::from(column).normalize());
        let along = |order: &[usize; 3]| {
            columns.iter().zip(order).map(|(column, &axis)| column[axis].abs()).sum::<f64>()
        };
        let mut best = ORDERS[0];
        for order in ORDERS {
            if along(&order) > along(&best) {
                best = order;
            }
        }
        Self([0, 1, 2].map(|i| (best[i], columns[i][best[i]] < 0.0)))
    }

    /// Returns the axes as a matrix, which turns coordinates of the image to those of space.
    pub(super) fn matrix(self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.0.map(|(axis, backwards)| {
            let mut column = [0.0; 3];
            column[axis] = if backwards { -1.0 } else { 1.0 };
            column
        }))
    }

    /// Returns the transform of voxel indices to those of the same image in another orientation.
    /// An axis that is turned around runs from its last voxel to its first.
    pub(super) fn to(self, other: Self, dimensions: DVec3) -> DAffine3 {
        let matrix = other.matrix().transpose() * self.matrix();
        // The image of the last voxel is the least index along each axis that is turned around.
        let last = matrix * (dimensions - DVec3::ONE);
        DAffine3 { matrix3: matrix, translation: (-last).max(DVec3::ZERO) }
    }
}
