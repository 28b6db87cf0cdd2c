//! Piecewise constant distributions: a cell with probability in proportion to its weight, and a
//! point in the cell.
//!
//! Cells are found by inverting the cumulative distribution. An alias table would find them in
//! constant time, but its map is not monotonic, so it would destroy the stratification of a Sobol
//! sequence.

use glam::Vec2;

/// A one-dimensional distribution; empty by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    sums: Sums,
    pub(crate) sum: f32,
}

/// A sampled cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drawn {
    pub(crate) cell: usize,
    /// Probability of the cell.
    pub(crate) chance: f32,
    /// The position of the random number within the cell, uniform in `0.0..1.0`.
    pub(crate) rest: f32,
}

impl Table {
    /// Makes a distribution of weights, which must not be negative. If all are zero, no cell can be
    /// sampled.
    pub(crate) fn new(weights: impl IntoIterator<Item = f32>) -> Self {
        let mut sums = Sums::default();
        let sum = sums.push_row(weights);
        Self { sums, sum }
    }

    /// Returns the probability of a cell.
    pub(crate) fn chance(&self, cell: usize) -> f32 {
        self.sums.chance(0, cell)
    }

    /// Samples a cell of positive probability by `u` in `0.0..1.0`, or returns `None` if there is
    /// none.
    pub(crate) fn draw(&self, u: f32) -> Option<Drawn> {
        self.sums.draw(0, u)
    }
}

/// Two-dimensional distributions over grids of the same size.
#[derive(Clone, Debug)]
pub(crate) struct Grids {
    width: usize,
    height: usize,
    /// Marginal distribution of the rows of each grid.
    rows: Sums,
    /// Conditional distribution of the columns of each row of each grid.
    columns: Sums,
}

impl Grids {
    /// Makes an empty list of grids of a size.
    pub(crate) fn new(width: usize, height: usize) -> Self {
        Self { width, height, rows: Sums::default(), columns: Sums::default() }
    }

    /// Appends a grid, and returns the sum of its weights. `weight(column, row)` must not be
    /// negative.
    pub(crate) fn push(&mut self, weight: impl Fn(usize, usize) -> f32) -> f32 {
        let Self { width, height, rows, columns } = self;
        let of_row = |row| columns.push_row((0..*width).map(|column| weight(column, row)));
        rows.push_row((0..*height).map(of_row))
    }

    /// Returns the number of grids.
    pub(crate) fn len(&self) -> usize {
        self.rows.cumulative.len() / (self.height + 1)
    }

    /// Returns the probability of a cell in its grid.
    pub(crate) fn chance(&self, grid: usize, [column, row]: [usize; 2]) -> f32 {
        self.rows.chance(grid, row) * self.columns.chance(grid * self.height + row, column)
    }

    /// Samples a cell. Returns column and row, their probability, and the position in the cell,
    /// uniform in the unit square.
    pub(crate) fn draw(&self, grid: usize, u: Vec2) -> Option<([usize; 2], f32, Vec2)> {
        let row = self.rows.draw(grid, u.y)?;
        let column = self.columns.draw(grid * self.height + row.cell, u.x)?;
        let chance = row.chance * column.chance;
        Some(([column.cell, row.cell], chance, Vec2::new(column.rest, row.rest)))
    }
}

/// Cumulative distributions of rows of the same length.
#[derive(Clone, Debug, Default)]
struct Sums {
    /// In each row, the probability of all cells before each; one more entry than cells.
    cumulative: Vec<f32>,
    /// Guide table: for each row and each of `buckets` equal parts of `0.0..1.0`, the first entry
    /// above the start of the part. A linear search from there passes [`SHARE`] entries on average,
    /// whatever the weights. The tables of a sky are larger than the caches, and a binary search of
    /// a row would touch seven cache lines.
    ///
    /// Source: H. Chen, Y. Asau, "On Generating Random Variates from an Empirical Distribution",
    /// AIIE Transactions 6(2), 1974.
    guide: Vec<u32>,
    buckets: usize,
    entries: usize,
}

/// Number of entries for each part of the guide table.
const SHARE: usize = 8;

impl Sums {
    /// Appends a row, and returns the sum of its weights.
    fn push_row(&mut self, weights: impl IntoIterator<Item = f32>) -> f32 {
        let mut sum = 0.0_f64;
        let mut sums = vec![0.0_f64];
        sums.extend(weights.into_iter().map(|weight| {
            sum += f64::from(weight);
            sum
        }));
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let start = self.cumulative.len();
        self.cumulative.extend(sums.iter().map(|&s| (s * scale) as f32));
        self.entries = sums.len();
        self.buckets = (self.entries - 1).div_ceil(SHARE).max(1);
        let (row, mut after) = (&self.cumulative[start..], 0);
        self.guide.extend((0..self.buckets).map(|bucket| {
            let begin = bucket as f32 / self.buckets as f32;
            after += row[after..].iter().take_while(|&&c| c <= begin).count();
            after as u32
        }));
        sum as f32
    }

    fn chance(&self, row: usize, cell: usize) -> f32 {
        let start = row * self.entries + cell;
        self.cumulative[start + 1] - self.cumulative[start]
    }

    fn draw(&self, row: usize, u: f32) -> Option<Drawn> {
        if self.entries == 0 {
            return None;
        }
        let cumulative = &self.cumulative[row * self.entries..][..self.entries];
        // The first entry is 0; the last is 1, or 0 if all weights are zero.
        let mut after = match self.buckets {
            // A short row is searched from its start.
            1 => 1,
            buckets => {
                let bucket = ((u * buckets as f32) as usize).min(buckets - 1);
                self.guide[row * buckets + bucket] as usize
            }
        };
        // The product may have been rounded up to the next bucket.
        while cumulative[after - 1] > u {
            after -= 1;
        }
        after += cumulative[after..].iter().take_while(|&&c| c <= u).count();
        let cell = after - 1;
        if after == self.entries {
            return None;
        }
        let chance = cumulative[after] - cumulative[cell];
        let rest = ((u - cumulative[cell]) / chance).min(1.0_f32.next_down());
        Some(Drawn { cell, chance, rest })
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
    fn an_empty_distribution_has_no_samples() {
        assert_eq!(Table::new([]).draw(0.5), None);
        assert_eq!(Table::new([0.0, 0.0]).draw(0.0), None);
        assert_eq!(Table::default().draw(0.5), None);
        let mut dark = Grids::new(2, 2);
        assert_eq!(dark.push(|_, _| 0.0), 0.0);
        assert_eq!(dark.draw(0, Vec2::splat(0.5)), None);
    }

    #[test]
    fn a_search_from_the_guide_finds_what_a_search_of_the_row_finds() {
        let uneven = |i: usize| if i % 3 == 1 { 0.0 } else { (1 + i * i % 7) as f32 };
        let sun = |i: usize| if i == 3 { 1e6 } else { 1.0 };
        for count in [1, 7, 8, 9, 15, 16, 17, 100, 1000] {
            for table in [Table::new((0..count).map(uneven)), Table::new((0..count).map(sun))] {
                let row = &table.sums.cumulative;
                // Also at each entry and right beside it, where parts of the guide begin and end.
                let beside = row.iter().flat_map(|&c| [c.next_down(), c, c.next_up()]);
                for u in (0..1000).map(|i| i as f32 / 1000.0).chain(beside) {
                    if !(0.0..1.0).contains(&u) {
                        continue;
                    }
                    let cell = row.partition_point(|&c| c <= u) - 1;
                    let drawn = table.draw(u).expect("it has weights");
                    assert_eq!(drawn.cell, cell, "{count} cells, {u}");
                    assert_eq!(drawn.chance, table.chance(cell));
                    assert!(drawn.chance > 0.0 && (0.0..1.0).contains(&drawn.rest), "{drawn:?}");
                }
            }
        }
    }

    #[test]
    fn grids_draw_places_in_proportion_to_their_weights() {
        let mut grids = Grids::new(3, 2);
        for shift in [0, 4] {
            let sum = grids.push(|column, row| (shift + column + 3 * row) as f32);
            assert_eq!(sum, (15 + 6 * shift) as f32);
        }
        for (grid, shift) in [0, 4].into_iter().enumerate() {
            let mut counts = [[0_u32; 3]; 2];
            for i in 0..150 {
                for j in 0..150 {
                    let u = (Vec2::new(i as f32, j as f32) + 0.5) / 150.0;
                    let (cell, chance, _) = grids.draw(grid, u).expect("it has weights");
                    assert!((chance - grids.chance(grid, cell)).abs() < 1e-7);
                    counts[cell[1]][cell[0]] += 1;
                }
            }
            let sum = (15 + 6 * shift) as f32;
            for (row, counts) in counts.iter().enumerate() {
                for (column, &count) in counts.iter().enumerate() {
                    let expected = (shift + column + 3 * row) as f32 / sum * 22500.0;
                    assert!((count as f32 - expected).abs() <= 150.0, "{column} {row}: {count}");
                }
            }
        }
    }
}
