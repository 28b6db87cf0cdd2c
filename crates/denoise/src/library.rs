//! The C interface of Open Image Denoise 2: the only unsafe code of the crate, behind safe calls.
//!
//! It follows the header `oidn.h` of version 2, whose functions and constants are stable within
//! that version. Libraries of another version are refused.

#![expect(unsafe_code, reason = "a library in C is called")]

use crate::DenoiseError;
use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::fmt;
use std::ptr;

type Handle = *mut c_void;

/// `OIDN_DEVICE_TYPE_CPU`.
const PROCESSOR: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;
/// The versions that have this interface.
const VERSIONS: std::ops::Range<c_int> = 20_000..30_000;

/// The functions of the library that are called.
#[derive(Clone, Copy)]
struct Functions {
    new_device: unsafe extern "C" fn(c_int) -> Handle,
    set_device_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    get_device_int: unsafe extern "C" fn(Handle, *const c_char) -> c_int,
    get_device_error: unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int,
    commit_device: unsafe extern "C" fn(Handle),
    release_device: unsafe extern "C" fn(Handle),
    new_filter: unsafe extern "C" fn(Handle, *const c_char) -> Handle,
    set_shared_filter_image: unsafe extern "C" fn(
        Handle,
        *const c_char,
        *mut c_void,
        c_int,
        usize,
        usize,
        usize,
        usize,
        usize,
    ),
    set_filter_bool: unsafe extern "C" fn(Handle, *const c_char, bool),
    commit_filter: unsafe extern "C" fn(Handle),
    execute_filter: unsafe extern "C" fn(Handle),
    release_filter: unsafe extern "C" fn(Handle),
}

/// The library with a device on the processor.
pub(crate) struct Library {
    functions: Functions,
    device: Handle,
    version: c_int,
    /// Keeps the functions loaded.
    _library: libloading::Library,
}

// SAFETY: the library says of devices that any thread may use them, one at a time or several.
unsafe impl Send for Library {}
// SAFETY: as above; filters are made, run and released within a call.
unsafe impl Sync for Library {}

impl fmt::Debug for Library {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Library").field("version", &self.version).finish_non_exhaustive()
    }
}

impl Functions {
    fn of(library: &libloading::Library) -> Result<Self, libloading::Error> {
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the header of the library declares the function with this type.
                *unsafe { library.get($name) }?
            };
        }
        Ok(Self {
            new_device: symbol!(c"oidnNewDevice"),
            set_device_bool: symbol!(c"oidnSetDeviceBool"),
            get_device_int: symbol!(c"oidnGetDeviceInt"),
            get_device_error: symbol!(c"oidnGetDeviceError"),
            commit_device: symbol!(c"oidnCommitDevice"),
            release_device: symbol!(c"oidnReleaseDevice"),
            new_filter: symbol!(c"oidnNewFilter"),
            set_shared_filter_image: symbol!(c"oidnSetSharedFilterImage"),
            set_filter_bool: symbol!(c"oidnSetFilterBool"),
            commit_filter: symbol!(c"oidnCommitFilter"),
            execute_filter: symbol!(c"oidnExecuteFilter"),
            release_filter: symbol!(c"oidnReleaseFilter"),
        })
    }
}

impl Library {
    /// Loads the library and starts a device.
    pub(crate) fn open(name: &OsStr) -> Result<Self, DenoiseError> {
        // SAFETY: a library runs code when it is loaded. Whoever sets the variable or installs the
        // library trusts it, as with any program that is run by its name.
        let library = unsafe { libloading::Library::new(name) }
            .map_err(|error| DenoiseError::Missing { problem: error.to_string() })?;
        let unsuitable = |problem: String| {
            let name = name.to_string_lossy().into_owned();
            DenoiseError::Unsuitable { name, problem }
        };
        let functions = Functions::of(&library).map_err(|error| unsuitable(error.to_string()))?;
        // SAFETY: the function is loaded; any integer may be passed.
        let device = unsafe { (functions.new_device)(PROCESSOR) };
        if device.is_null() {
            return Err(DenoiseError::Failed {
                problem: "it supports no processor like this".to_owned(),
            });
        }
        let mut loaded = Self { functions, device, version: 0, _library: library };
        // SAFETY: the device is valid until `loaded` is dropped; the names end with zero. Threads
        // are not bound to processors, which other threads of the program need too.
        unsafe {
            (functions.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (functions.commit_device)(device);
            loaded.version = (functions.get_device_int)(device, c"version".as_ptr());
        }
        loaded.check()?;
        if !VERSIONS.contains(&loaded.version) {
            return Err(unsuitable(format!("its version is {}", loaded.version)));
        }
        Ok(loaded)
    }

    /// Returns the version as a number: 20501 for 2.5.1.
    pub(crate) fn version(&self) -> c_int {
        self.version
    }

    /// Runs the filter for ray-traced pictures over images of `width x height` pixels with the
    /// names that it knows, and returns its output.
    ///
    /// # Panics
    ///
    /// If an image has another number of pixels.
    pub(crate) fn run(
        &self,
        [width, height]: [usize; 2],
        inputs: &[(&CStr, &[[f32; 3]])],
        flags: &[(&CStr, bool)],
    ) -> Result<Vec<[f32; 3]>, DenoiseError> {
        let mut output = vec![[0.0_f32; 3]; width * height];
        let functions = &self.functions;
        // SAFETY: the device is valid, and the name ends with zero.
        let filter = unsafe { (functions.new_filter)(self.device, c"RT".as_ptr()) };
        if filter.is_null() {
            self.check()?;
            return Err(DenoiseError::Failed { problem: "there is no filter RT".to_owned() });
        }
        for (name, image) in inputs {
            assert_eq!(image.len(), width * height, "{name:?} has the size of the picture");
            // SAFETY: the image has `width * height` triples without gaps and outlives the filter,
            // which reads inputs only.
            unsafe {
                let data = image.as_ptr().cast::<c_void>().cast_mut();
                (functions.set_shared_filter_image)(
                    filter,
                    name.as_ptr(),
                    data,
                    FLOAT3,
                    width,
                    height,
                    0,
                    0,
                    0,
                );
            }
        }
        // SAFETY: the output has as many triples, is borrowed by nobody else, and outlives the
        // filter, which is released here. Zero strides stand for images without gaps.
        unsafe {
            (functions.set_shared_filter_image)(
                filter,
                c"output".as_ptr(),
                output.as_mut_ptr().cast(),
                FLOAT3,
                width,
                height,
                0,
                0,
                0,
            );
            for (name, value) in flags {
                (functions.set_filter_bool)(filter, name.as_ptr(), *value);
            }
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
            (functions.release_filter)(filter);
        }
        self.check()?;
        Ok(output)
    }

    /// Returns the error that has occurred since the last call, if any.
    fn check(&self) -> Result<(), DenoiseError> {
        let mut text: *const c_char = ptr::null();
        // SAFETY: the device is valid. The text, if there is one, is valid until the next call for
        // this thread, and is copied before.
        let problem = unsafe {
            if (self.functions.get_device_error)(self.device, &raw mut text) == 0 {
                return Ok(());
            }
            if text.is_null() {
                "an unknown error".to_owned()
            } else {
                CStr::from_ptr(text).to_string_lossy().into_owned()
            }
        };
        Err(DenoiseError::Failed { problem: problem.lines().collect::<Vec<_>>().join("; ") })
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        // SAFETY: the device is valid and used no more; the library is unloaded after this.
        unsafe { (self.functions.release_device)(self.device) }
    }
}
