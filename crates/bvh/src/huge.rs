//! Memory in huge pages, for what rays touch at random.
#![cfg_attr(target_os = "linux", expect(unsafe_code, reason = "a hint to the kernel"))]

/// An empty vector with room for `capacity` elements, in huge pages where the system has them to give.
///
/// A tree is larger than what the processor remembers of small pages, and a walk touches a new one
/// with nearly every node.
pub(crate) fn vec_with_capacity<T>(capacity: usize) -> Vec<T> {
    let vec: Vec<T> = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let start = vec.as_ptr().addr().next_multiple_of(PAGE);
        let end = (vec.as_ptr().addr() + vec.capacity() * size_of::<T>()) / PAGE * PAGE;
        if end > start + (2 << 20) {
            // SAFETY: the range lies in the allocation. The hint changes neither contents nor access;
            // where the kernel does not know it, it refuses, and nothing is lost.
            unsafe {
                libc::madvise(
                    std::ptr::without_provenance_mut(start),
                    end - start,
                    libc::MADV_HUGEPAGE,
                );
            }
        }
    }
    vec
}
