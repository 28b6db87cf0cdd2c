//! Images in memory that is used again: a hand that moves for hours makes a hundred thousand, of
//! changing sizes, and an allocator that is asked for each of them keeps ever more.

use rotund_image::Image;
use rotund_trace::Film;
use std::sync::Arc;

/// Images that have been handed out.
#[derive(Debug, Default)]
pub(crate) struct Buffers(Vec<Arc<Image>>);

impl Buffers {
    /// Returns the image of a film, in the memory of one that nobody holds any more.
    pub(crate) fn develop(&mut self, film: &Film) -> Arc<Image> {
        let free = self.0.iter_mut().position(|image| Arc::get_mut(image).is_some());
        let index = free.unwrap_or_else(|| {
            self.0.push(Arc::new(Image { width: 0, height: 0, pixels: Vec::new() }));
            self.0.len() - 1
        });
        let image = &mut self.0[index];
        film.develop(Arc::get_mut(image).expect("nobody else holds it"));
        Arc::clone(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_memory_of_an_image_is_used_again_once_nobody_holds_it() {
        let (mut large, mut small) =
            (Film::new(8, 8).expect("a size"), Film::new(2, 1).expect("a size"));
        large.add(7, 7, Vec3::ONE, true).expect("a pixel of the film");
        small.add(1, 0, Vec3::ONE, true).expect("a pixel of the film");
        let mut buffers = Buffers::default();
        let first = buffers.develop(&large);
        let second = buffers.develop(&small);
        assert_eq!((&*first, &*second), (&large.image(), &small.image()), "both are held");
        let place = first.pixels.as_ptr();
        drop(first);
        let third = buffers.develop(&small);
        assert_eq!(*third, small.image());
        assert_eq!(third.pixels.as_ptr(), place);
        assert_eq!(buffers.0.len(), 2);
    }
}
