//! Instruction sets, selected at run time.

#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Portable, Simd, WithSimd};
use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

/// A vector instruction set for traversal. Every set gives the same answers, to the bit.
///
/// A value exists only for a set that the processor supports.
#[derive(Clone, Copy)]
pub struct Isa(Kind);

#[derive(Clone, Copy)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
}

impl Isa {
    /// The baseline of the architecture, which every processor supports: SSE2 on x86-64, NEON on
    /// AArch64.
    pub const PORTABLE: Self = Self(Kind::Portable);

    /// All sets that this processor supports, fastest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        [
            Some(Self::PORTABLE),
            #[cfg(target_arch = "x86_64")]
            Avx2::new().map(|isa| Self(Kind::Avx2(isa))),
            #[cfg(target_arch = "x86_64")]
            Avx512::new().map(|isa| Self(Kind::Avx512(isa))),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// The set that new trees use: the one named by the environment variable `ROTUND_ISA`
    /// (`portable`, `sse2`, `avx2`, `avx512`) if the processor supports it, else the fastest.
    /// Determined once per process.
    #[must_use]
    pub fn default_set() -> Self {
        static DEFAULT: OnceLock<Isa> = OnceLock::new();
        *DEFAULT.get_or_init(|| {
            let fastest = Self::available().pop().unwrap_or(Self::PORTABLE);
            std::env::var("ROTUND_ISA").ok().and_then(|name| name.parse().ok()).unwrap_or(fastest)
        })
    }

    /// The name of the set, as [`Isa::from_str`] parses it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(_) => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(_) => "avx512",
        }
    }

    /// Runs a computation in a function that is compiled for this set.
    #[inline]
    pub fn vectorize<T: Vectorize>(self, task: T) -> T::Output {
        self.run(Portably(task))
    }

    #[inline(always)]
    pub(crate) fn run<T: WithSimd>(self, task: T) -> T::Output {
        match self.0 {
            // Outlined, so that its stack is not reserved for the other sets.
            Kind::Portable => Portable.run_outlined(task),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2(isa) => isa.run(task),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512(isa) => isa.run(task),
        }
    }
}

/// A computation on arrays of numbers, which the compiler turns into vector instructions: see
/// [`Isa::vectorize`].
pub trait Vectorize {
    /// The result.
    type Output;

    /// Computes it. Implementations are `#[inline(always)]`, and so is what they call: only code
    /// that is inlined is compiled for the instruction set.
    fn run(self) -> Self::Output;
}

/// A task that needs no vector operations by name.
struct Portably<T>(T);

impl<T: Vectorize> WithSimd for Portably<T> {
    type Output = T::Output;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> T::Output {
        self.0.run()
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl PartialEq for Isa {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Isa {}

/// The error for a name that is not that of an instruction set of this processor. Its text lists
/// the names that are.
#[derive(Clone, Debug)]
pub struct UnknownIsa(String);

impl fmt::Display for UnknownIsa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = Isa::available().into_iter().map(Isa::name).collect();
        write!(
            f,
            "this processor has no instruction set {:?}; it has: {}",
            self.0,
            names.join(", ")
        )
    }
}

impl std::error::Error for UnknownIsa {}

impl FromStr for Isa {
    type Err = UnknownIsa;

    /// Parses an [`Isa::name`]. On x86-64 `sse2` is another name of the portable set, which
    /// compiles to SSE2 there.
    fn from_str(name: &str) -> Result<Self, UnknownIsa> {
        if cfg!(target_arch = "x86_64") && name == "sse2" {
            return Ok(Self::PORTABLE);
        }
        Self::available()
            .into_iter()
            .find(|isa| isa.name() == name)
            .ok_or_else(|| UnknownIsa(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_is_parsed_from_its_name() {
        for isa in Isa::available() {
            assert_eq!(isa.name().parse::<Isa>().ok(), Some(isa));
        }
        let sse2 = "sse2".parse::<Isa>().ok();
        assert_eq!(sse2, cfg!(target_arch = "x86_64").then_some(Isa::PORTABLE));
        let unknown = "mmx".parse::<Isa>().expect_err("no such set").to_string();
        assert!(unknown.contains("\"mmx\"") && unknown.contains("portable"), "{unknown}");
    }
}
