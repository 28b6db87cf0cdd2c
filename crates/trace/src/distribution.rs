//! Drawing from tables: a cell with a chance in proportion to its weight, and a place in the cell.
//!
//! Cells are found by inverting the cumulative sum. An alias table would find them in constant time,
//! but it would scatter neighbouring numbers, and with them the evenness of a Sobol sequence.

use glam::Vec2;

/// A table of weights; none by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// `cumulative[i]` is the chance of the cells before `i`; one more entry than cells.
    cumulative: Vec<f32>,
    pub(crate) sum: f32,
}

/// A cell that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawn {
    pub(crate) cell: usize,
    /// The chance of the cell.
    pub(crate) chance: f32,
    /// Uniform in `0.0..1.0`: what the choice left over.
    pub(crate) rest: f32,
}

impl Table {
    /// Weights must not be negative. If all are zero, nothing can be drawn.
    pub(crate) fn new(weights: impl IntoIterator<Item = f32>) -> Self {
        let mut sum = 0.0_f64;
        let mut sums = vec![0.0_f64];
        sums.extend(weights.into_iter().map(|weight| {
            sum += f64::from(weight);
            sum
        }));
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let cumulative = sums.iter().map(|&s| (s * scale) as f32).collect();
        Self { cumulative, sum: sum as f32 }
    }

    /// The chance of a cell.
    pub(crate) fn chance(&self, cell: usize) -> f32 {
        self.cumulative[cell + 1] - self.cumulative[cell]
    }

    /// `u` in `0.0..1.0` picks a cell that has a chance; none if no cell has.
    pub(crate) fn draw(&self, u: f32) -> Option<Drawn> {
        // The last entry is 1 or, if nothing can be drawn, 0.
        let after = self.cumulative.partition_point(|&c| c <= u);
        let cell = after.checked_sub(1).filter(|_| after < self.cumulative.len())?;
        let chance = self.chance(cell);
        let rest = ((u - self.cumulative[cell]) / chance).min(1.0_f32.next_down());
        Some(Drawn { cell, chance, rest })
    }
}

/// A grid of weights.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    rows: Table,
    columns: Vec<Table>,
}

impl Grid {
    /// `weight(column, row)` must not be negative.
    pub(crate) fn new(width: usize, height: usize, weight: impl Fn(usize, usize) -> f32) -> Self {
        let columns: Vec<Table> = (0..height)
            .map(|row| Table::new((0..width).map(|column| weight(column, row))))
            .collect();
        Self { rows: Table::new(columns.iter().map(|row| row.sum)), columns }
    }

    /// The sum of all weights.
    pub(crate) fn sum(&self) -> f32 {
        self.rows.sum
    }

    /// The chance of a cell.
    pub(crate) fn chance(&self, column: usize, row: usize) -> f32 {
        self.rows.chance(row) * self.columns[row].chance(column)
    }

    /// Column, row, its chance, and a place in the cell, uniform in the unit square.
    pub(crate) fn draw(&self, u: Vec2) -> Option<([usize; 2], f32, Vec2)> {
        let row = self.rows.draw(u.y)?;
        let column = self.columns[row.cell].draw(u.x)?;
        let chance = row.chance * column.chance;
        Some(([column.cell, row.cell], chance, Vec2::new(column.rest, row.rest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_draws_cells_in_proportion_to_their_weights() {
        let table = Table::new([1.0, 0.0, 3.0, 0.0]);
        let drawn = |u| table.draw(u).map(|d| (d.cell, d.chance, d.rest));
        assert_eq!(drawn(0.0), Some((0, 0.25, 0.0)));
        assert_eq!(drawn(0.125), Some((0, 0.25, 0.5)));
        assert_eq!(drawn(0.25), Some((2, 0.75, 0.0)));
        assert_eq!(drawn(0.625), Some((2, 0.75, 0.5)));
        assert_eq!(drawn(1.0_f32.next_down()).map(|d| d.0), Some(2));
        assert_eq!(table.sum, 4.0);
    }

    #[test]
    fn nothing_is_drawn_from_nothing() {
        assert_eq!(Table::new([]).draw(0.5), None);
        assert_eq!(Table::new([0.0, 0.0]).draw(0.0), None);
        assert_eq!(Grid::new(2, 2, |_, _| 0.0).draw(Vec2::splat(0.5)), None);
    }

    #[test]
    fn a_grid_draws_places_in_proportion_to_their_weights() {
        let grid = Grid::new(3, 2, |column, row| (column + 3 * row) as f32);
        let mut counts = [[0_u32; 3]; 2];
        for i in 0..150 {
            for j in 0..150 {
                let u = (Vec2::new(i as f32, j as f32) + 0.5) / 150.0;
                let ([column, row], chance, _) = grid.draw(u).expect("it has weights");
                assert!((chance - grid.chance(column, row)).abs() < 1e-7);
                counts[row][column] += 1;
            }
        }
        for (row, counts) in counts.iter().enumerate() {
            for (column, &count) in counts.iter().enumerate() {
                let expected = (column + 3 * row) as f32 / 15.0 * 22500.0;
                assert!((count as f32 - expected).abs() <= 150.0, "{column} {row}: {count}");
            }
        }
    }
}
