//! Vectors in huge pages, for memory that rays access at random.
#![cfg_attr(target_os = "linux", expect(unsafe_code, reason = "a hint to the kernel"))]

/// An empty vector with room for `capacity` elements, in huge pages where the system provides them.
///
/// A tree spans more small pages than the TLB covers, and a traversal touches a new page with
/// nearly every node; huge pages avoid most of these TLB misses.
pub(crate) fn vec_with_capacity<T>(capacity: usize) -> Vec<T> {
    let vec: Vec<T> = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let start = vec.as_ptr().addr().next_multiple_of(PAGE);
        let end = (vec.as_ptr().addr() + vec.capacity() * size_of::<T>()) / PAGE * PAGE;
        if end > start + (2 << 20) {
            // SAFETY: the range lies in the allocation, and the hint changes neither its contents
            // nor the access to it. A kernel that does not know the hint refuses it, without any
            // effect.
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
