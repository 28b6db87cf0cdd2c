//! A piecewise constant density over an image, of adaptive resolution.

use crate::distribution::Grids;
use glam::Vec2;

/// A density that is constant in each cell of a grid or, where the variance hardly rises, in each
/// block of cells.
///
/// A few thousand blocks represent the smooth part of a sky and fit into the caches, which a table
/// of all cells does not. Around the sun the resolution is that of the cells.
#[derive(Clone, Debug)]
pub(super) struct Mosaic {
    width: usize,
    /// Upper edges of the rows and the lower edge of the last, decreasing. Columns have width 1.
    edges: Vec<f32>,
    /// Integral of the brightness. It may exceed the range of `f32`.
    pub(super) sum: f64,
    /// Number of blocks in a row.
    across: usize,
    /// A single grid: the distribution of the blocks.
    blocks: Grids,
    kinds: Vec<Kind>,
    /// Distributions of the cells of some blocks; cells outside of the image have weight 0.
    cells: Grids,
}

/// The density in a block.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Constant.
    Constant(f32),
    /// That of the cells of this grid.
    Cells(u32),
}

/// Number of columns and of rows of a block.
const SIDE: usize = 8;

/// Variance that blocks may add to an estimate of the integral, relative to the square of the
/// integral. The cells alone would have none.
const VARIANCE: f64 = 1e-3;

impl Mosaic {
    /// Makes a density in proportion to `brightness`, which must not be negative, with `width`
    /// numbers for each row.
    pub(super) fn new(width: usize, edges: Vec<f32>, brightness: &[f32]) -> Self {
        let (across, down) = (width.div_ceil(SIDE), (edges.len() - 1).div_ceil(SIDE));
        let mut mosaic = Self {
            width,
            edges,
            sum: 0.0,
            across,
            blocks: Grids::new(across, down),
            kinds: Vec::new(),
            cells: Grids::new(SIDE, SIDE),
        };
        let moments: Vec<Moments> =
            (0..across * down).map(|block| mosaic.moments(block, brightness)).collect();
        mosaic.sum = moments.iter().map(|block| block.weight).sum();
        let scale = mosaic.sum.max(f64::MIN_POSITIVE).recip();
        mosaic.blocks.push(|x, y| (moments[y * across + x].weight * scale) as f32);
        let constant = |(block, moments): (usize, &Moments)| {
            let chance = mosaic.blocks.chance(0, [block % across, block / across]);
            Kind::Constant(chance / moments.area as f32)
        };
        mosaic.kinds = moments.iter().enumerate().map(constant).collect();
        for block in blocks_of_cells(&moments, VARIANCE * mosaic.sum) {
            mosaic.kinds[block] = Kind::Cells(mosaic.cells.len() as u32);
            let [left, top] = mosaic.corner(block);
            let rows = mosaic.edges.len() - 1;
            let edges = &mosaic.edges;
            mosaic.cells.push(|x, y| {
                let (column, row) = (left + x, top + y);
                let inside = column < width && row < rows;
                if inside {
                    brightness[row * width + column] * (edges[row] - edges[row + 1])
                } else {
                    0.0
                }
            });
        }
        mosaic
    }

    /// Samples a point `[x, y]`. Returns it with its density per area, or `None` if the density is
    /// 0 everywhere.
    pub(super) fn draw(&self, u: Vec2) -> Option<(Vec2, f32)> {
        let ([x, y], chance, place) = self.blocks.draw(0, u)?;
        let block = y * self.across + x;
        let [left, top] = self.corner(block);
        let between = |from: f32, to: f32, s: f32| from + s * (to - from);
        match self.kinds[block] {
            Kind::Constant(density) => {
                let (right, bottom) = self.end(left, top);
                let x = between(left as f32, right as f32, place.x);
                Some((Vec2::new(x, between(self.edges[top], self.edges[bottom], place.y)), density))
            }
            Kind::Cells(cells) => {
                let ([x, y], share, place) = self.cells.draw(cells as usize, place)?;
                let row = top + y;
                let (from, to) = (self.edges[row], self.edges[row + 1]);
                let place = Vec2::new((left + x) as f32 + place.x, between(from, to, place.y));
                Some((place, chance * share / (from - to)))
            }
        }
    }

    /// Returns the density in a cell.
    pub(super) fn density(&self, column: usize, row: usize) -> f32 {
        let (x, y) = (column / SIDE, row / SIDE);
        match self.kinds[y * self.across + x] {
            Kind::Constant(density) => density,
            Kind::Cells(cells) => {
                let share = self.cells.chance(cells as usize, [column % SIDE, row % SIDE]);
                let chance = self.blocks.chance(0, [x, y]) * share;
                chance / (self.edges[row] - self.edges[row + 1])
            }
        }
    }

    /// Returns column and row of the first cell of a block.
    fn corner(&self, block: usize) -> [usize; 2] {
        [block % self.across * SIDE, block / self.across * SIDE]
    }

    /// Returns the ends of the columns and rows of the block whose first cell this is.
    fn end(&self, left: usize, top: usize) -> (usize, usize) {
        ((left + SIDE).min(self.width), (top + SIDE).min(self.edges.len() - 1))
    }

    fn moments(&self, block: usize, brightness: &[f32]) -> Moments {
        let [left, top] = self.corner(block);
        let (right, bottom) = self.end(left, top);
        let mut moments = Moments::default();
        for row in top..bottom {
            let area = f64::from(self.edges[row] - self.edges[row + 1]);
            for &b in &brightness[row * self.width..][left..right] {
                moments.area += area;
                moments.weight += f64::from(b) * area;
                moments.square += f64::from(b).powi(2) * area;
            }
        }
        moments
    }
}

/// Integrals of 1, the brightness and its square over a block.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    area: f64,
    weight: f64,
    square: f64,
}

/// Returns the blocks that need the resolution of cells, so that the others add at most `most` to
/// the second moment.
fn blocks_of_cells(moments: &[Moments], most: f64) -> Vec<usize> {
    // The estimate is brightness over density. With the density `weight / area / total` of a block
    // instead of `brightness / total` its second moment is `square area / weight`, not `weight`,
    // times the total.
    let excess = |block: &usize| {
        let Moments { area, weight, square } = moments[*block];
        if weight > 0.0 { square * area / weight - weight } else { 0.0 }
    };
    let mut blocks: Vec<usize> = (0..moments.len()).collect();
    blocks.sort_by(|a, b| excess(b).total_cmp(&excess(a)));
    let mut rest = most;
    while let Some(block) = blocks.last() {
        rest -= excess(block);
        if rest < 0.0 {
            break;
        }
        blocks.pop();
    }
    blocks.sort_unstable();
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of different heights, as those of a sky.
    fn edges(rows: usize) -> Vec<f32> {
        (0..=rows).map(|edge| (3.0 * edge as f32 / rows as f32).cos()).collect()
    }

    fn smooth(column: usize, row: usize) -> f32 {
        1.0 + 0.01 * (column as f32 * 0.1).sin() + 0.001 * row as f32
    }

    fn sun(column: usize, row: usize) -> f32 {
        smooth(column, row) + if [column, row] == [9, 5] { 1000.0 } else { 0.0 }
    }

    fn left_half(column: usize, _: usize) -> f32 {
        if column < 10 { 1.0 } else { 0.0 }
    }

    fn mosaic(size: [usize; 2], brightness: fn(usize, usize) -> f32) -> (Mosaic, Vec<f32>) {
        let [width, height] = size;
        let cells = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        let brightness: Vec<f32> = cells.map(|(column, row)| brightness(column, row)).collect();
        (Mosaic::new(width, edges(height), &brightness), brightness)
    }

    #[test]
    fn blocks_add_no_more_than_the_variance_that_is_allowed() {
        let images = [smooth, sun, left_half];
        for size in [[1, 1], [3, 1], [8, 8], [9, 17], [64, 32], [50, 45]] {
            for image in images {
                let ([width, height], (mosaic, brightness)) = (size, mosaic(size, image));
                let (mut all, mut sum, mut square) = (0.0, 0.0, 0.0);
                for (i, &b) in brightness.iter().enumerate() {
                    let (column, row) = (i % width, i / width);
                    let area = f64::from(mosaic.edges[row] - mosaic.edges[row + 1]);
                    let density = f64::from(mosaic.density(column, row));
                    all += density * area;
                    sum += f64::from(b) * area;
                    if b > 0.0 {
                        square += f64::from(b).powi(2) / density * area;
                    }
                }
                assert!((all - 1.0).abs() < 1e-5, "{size:?}: the density sums to {all}");
                assert!((mosaic.sum / sum - 1.0).abs() < 1e-12, "{size:?}");
                let variance = square / (sum * sum) - 1.0;
                assert!(variance < VARIANCE + 1e-5, "{width} x {height}: {variance}");
            }
        }
    }

    #[test]
    fn blocks_have_cells_only_where_it_is_uneven() {
        let count = |image| {
            let (mosaic, _) = mosaic([64, 32], image);
            mosaic.kinds.iter().filter(|kind| matches!(kind, Kind::Cells(_))).count()
        };
        assert_eq!(count(smooth), 0);
        assert_eq!(count(sun), 1);
        assert_eq!(count(left_half), 4, "columns 8 to 15");
    }

    #[test]
    fn places_are_drawn_in_proportion_to_their_density() {
        const COUNT: u32 = 1 << 16;
        for image in [smooth, sun, left_half] {
            let size @ [width, height] = [21, 13];
            let (mosaic, _) = mosaic(size, image);
            let mut counts = vec![0_u32; width * height];
            for i in 0..COUNT {
                // Hammersley's points: a rectangle holds its share of them up to a few.
                let u = Vec2::new(i as f32, (i.reverse_bits() >> 16) as f32) / COUNT as f32;
                let (place, density) = mosaic.draw(u).expect("it shines");
                let row = mosaic.edges.partition_point(|&edge| edge >= place.y) - 1;
                let (column, row) = (place.x as usize, row.min(height - 1));
                let again = mosaic.density(column, row);
                assert!((density - again).abs() <= 1e-4 * density, "{place}: {density}, {again}");
                counts[row * width + column] += 1;
            }
            for (i, &count) in counts.iter().enumerate() {
                let (column, row) = (i % width, i / width);
                let area = mosaic.edges[row] - mosaic.edges[row + 1];
                let expected = mosaic.density(column, row) * area * COUNT as f32;
                assert!(
                    (count as f32 - expected).abs() < 16.0,
                    "{column} {row}: {count}, {expected}"
                );
            }
        }
    }

    #[test]
    fn the_scale_of_the_brightness_does_not_matter() {
        let (mosaic, brightness) = mosaic([64, 32], sun);
        for scale in [1e-30, 1e35] {
            let scaled: Vec<f32> = brightness.iter().map(|b| scale * b).collect();
            let scaled = Mosaic::new(64, edges(32), &scaled);
            assert!((scaled.sum / (f64::from(scale) * mosaic.sum) - 1.0).abs() < 1e-6, "{scale}");
            for (column, row) in [(0, 0), (9, 5), (10, 5), (63, 31)] {
                let (a, b) = (scaled.density(column, row), mosaic.density(column, row));
                assert!((a - b).abs() <= 1e-4 * b, "{scale}, {column} {row}: {a}, {b}");
            }
        }
    }

    #[test]
    fn nothing_is_drawn_where_all_is_dark() {
        let (mosaic, _) = mosaic([20, 10], |_, _| 0.0);
        assert_eq!(mosaic.sum, 0.0);
        assert_eq!(mosaic.draw(Vec2::splat(0.5)), None);
        assert_eq!(mosaic.density(3, 3), 0.0);
    }
}
