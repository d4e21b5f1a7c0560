//! Open Image Denoise 2, a library that is loaded when it is asked for.
#![allow(unsafe_code)]

use std::env;
use std::error::Error as _;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::PathBuf;
use std::sync::OnceLock;

use libloading::Library;

use crate::error::{Error, Result};
use crate::image::Image;

/// Names the library, or the folder that has it.
const VARIABLE: &str = "PTFAST_OIDN";
/// The file that the system looks for in its folders of libraries.
const FILE: &str = if cfg!(windows) {
    "OpenImageDenoise.dll"
} else if cfg!(target_vendor = "apple") {
    "libOpenImageDenoise.2.dylib"
} else {
    "libOpenImageDenoise.so.2"
};
/// The first version of version 2, as the library counts.
const VERSION_2: c_int = 20_000;
/// Values of enums of the library.
const CPU: c_int = 1;
const THREE_FLOATS: c_int = 3;

#[repr(C)]
struct DeviceOf(c_void);
#[repr(C)]
struct FilterOf(c_void);
type Device = *mut DeviceOf;
type Filter = *mut FilterOf;
type Text = *const c_char;

/// Declares the functions of the library's C interface that are used, and how they are found.
macro_rules! functions {
    ($($name:ident = $symbol:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            /// # Safety
            /// Functions of these names must have these types, and the library must stay loaded.
            unsafe fn find(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the caller's.
                Ok(Self { $($name: *unsafe { library.get($symbol) }?,)* })
            }
        }
    };
}

functions! {
    new_device = "oidnNewDevice" (c_int) -> Device;
    set_device_bool = "oidnSetDeviceBool" (Device, Text, bool);
    set_device_int = "oidnSetDeviceInt" (Device, Text, c_int);
    get_device_int = "oidnGetDeviceInt" (Device, Text) -> c_int;
    commit_device = "oidnCommitDevice" (Device);
    get_device_error = "oidnGetDeviceError" (Device, *mut Text) -> c_int;
    release_device = "oidnReleaseDevice" (Device);
    new_filter = "oidnNewFilter" (Device, Text) -> Filter;
    set_image = "oidnSetSharedFilterImage" (Filter, Text, *mut c_void, c_int, usize, usize, usize, usize, usize);
    set_filter_bool = "oidnSetFilterBool" (Filter, Text, bool);
    commit_filter = "oidnCommitFilter" (Filter);
    execute_filter = "oidnExecuteFilter" (Filter);
    release_filter = "oidnReleaseFilter" (Filter);
}

/// The library.
struct Oidn {
    functions: Functions,
    /// Such as 20501 for 2.5.1.
    version: c_int,
}

/// The version of the installed library.
pub(super) fn version() -> Result<String> {
    let version = library()?.version;
    Ok(format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100))
}

/// `color` without noise, by the features of `image`, which has the same size. The library uses as many threads as the
/// current pool has.
pub(super) fn denoised(image: &Image, color: &[[f32; 3]]) -> Result<Vec<[f32; 3]>> {
    let Oidn { functions, .. } = library()?;
    assert_eq!(color.len(), image.pixels().len(), "one colour per pixel");
    let mut output = vec![[0.0; 3]; color.len()];
    let [width, height] = [image.width(), image.height()].map(|size| size as usize);
    let layer = |name: &str| image.layer(name).map(|layer| layer.values());
    let inputs =
        [(c"color", Some(color)), (c"albedo", layer("albedo")), (c"normal", layer("normal"))];
    // SAFETY: all images have `width` × `height` values of three floats, and outlive the filter, which writes only
    // to the output. Device and filter are used by this thread alone until they are released.
    unsafe {
        let device = functions.device()?;
        let filter = (functions.new_filter)(device, c"RT".as_ptr());
        let set = |name: &CStr, values: *mut c_void| {
            let name = name.as_ptr();
            (functions.set_image)(filter, name, values, THREE_FLOATS, width, height, 0, 0, 0);
        };
        for (name, values) in inputs {
            if let Some(values) = values {
                set(name, values.as_ptr().cast_mut().cast());
            }
        }
        set(c"output", output.as_mut_ptr().cast());
        (functions.set_filter_bool)(filter, c"hdr".as_ptr(), true);
        (functions.commit_filter)(filter);
        (functions.execute_filter)(filter);
        let done = functions.check(device);
        (functions.release_filter)(filter);
        (functions.release_device)(device);
        done?;
    }
    Ok(output)
}

/// The library, which is loaded once.
fn library() -> Result<&'static Oidn> {
    static LIBRARY: OnceLock<Result<Oidn, String>> = OnceLock::new();
    let library = LIBRARY.get_or_init(|| Oidn::load().map_err(|error| error.to_string()));
    library.as_ref().map_err(|error| Error::Resource(error.clone()))
}

impl Oidn {
    fn load() -> Result<Self> {
        let fails = |problem: String| {
            let advice = format!("install it, or set {VARIABLE} to the folder of {FILE}");
            Error::Resource(one_line(format!("Open Image Denoise 2: {problem}; {advice}")))
        };
        // The source names the file, and says more than the error.
        let reason = |error: libloading::Error| {
            error.source().map_or_else(|| error.to_string(), ToString::to_string)
        };
        let place = place();
        // SAFETY: the library is the one that the user chose. It stays loaded, since its threads may outlive a device.
        let functions = unsafe {
            let library = Library::new(&place).map_err(|error| fails(reason(error)))?;
            let functions = Functions::find(&library);
            std::mem::forget(library);
            functions.map_err(|error| fails(format!("another version? {}", reason(error))))?
        };
        // SAFETY: the device is used by this thread alone until it is released.
        let version = unsafe {
            let device = functions.device()?;
            let version = (functions.get_device_int)(device, c"version".as_ptr());
            (functions.release_device)(device);
            version
        };
        match version {
            VERSION_2.. => Ok(Self { functions, version }),
            _ => Err(fails(format!("{} is an older version", place.display()))),
        }
    }
}

impl Functions {
    /// A new device.
    ///
    /// # Safety
    /// The functions must be those of the library.
    unsafe fn device(&self) -> Result<Device> {
        // SAFETY: the library allows all of these calls for any device, even none.
        unsafe {
            let device = (self.new_device)(CPU);
            let threads = rayon::current_num_threads() as c_int;
            (self.set_device_int)(device, c"numThreads".as_ptr(), threads);
            // Other programs and other parts of this one use the cores, too.
            (self.set_device_bool)(device, c"setAffinity".as_ptr(), false);
            (self.commit_device)(device);
            match self.check(device) {
                Ok(()) => Ok(device),
                Err(error) => {
                    (self.release_device)(device);
                    Err(error)
                }
            }
        }
    }

    /// # Errors
    /// The first error of `device` since the last check.
    ///
    /// # Safety
    /// `device` must be one of the library, or null.
    unsafe fn check(&self, device: Device) -> Result<()> {
        let mut message: Text = std::ptr::null();
        // SAFETY: the message is a string of the library, which is valid until the next call.
        let text = unsafe {
            match (self.get_device_error)(device, &raw mut message) {
                0 => return Ok(()),
                code if message.is_null() => format!("error {code}"),
                _ => CStr::from_ptr(message).to_string_lossy().into_owned(),
            }
        };
        Err(Error::Resource(one_line(format!("Open Image Denoise: {text}"))))
    }
}

/// Messages of libraries and of systems can have several lines.
fn one_line(message: String) -> String {
    message.replace('\n', " ")
}

/// The library's file, or its name for the system to find.
fn place() -> PathBuf {
    match env::var_os(VARIABLE).filter(|value| !value.is_empty()) {
        Some(value) => {
            let path = PathBuf::from(value);
            if path.is_dir() { path.join(FILE) } else { path }
        }
        None => PathBuf::from(FILE),
    }
}
