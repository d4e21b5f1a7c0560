//! Open Image Denoise 2, a library that is loaded when it is asked for.
#![allow(unsafe_code)]

use std::env;
use std::error::Error as _;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use libloading::Library;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::math::Real;

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
/// The first versions of 2 and of 3, as the library counts.
const VERSION_2: c_int = 20_000;
const VERSION_3: c_int = 30_000;
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
    Ok(named(library()?.version))
}

fn named(version: c_int) -> String {
    format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
}

/// Each of `colors` without noise, by the features of `image`, which has the same size. The library uses as many threads
/// as the current pool has.
pub(super) fn denoised<const N: usize>(
    image: &Image,
    colors: [&[[f32; 3]]; N],
) -> Result<[Vec<[f32; 3]>; N]> {
    let Oidn { functions, .. } = library()?;
    let count = image.pixels().len();
    let [width, height] = [image.width(), image.height()].map(|size| size as usize);
    let layer = |name: &str| image.layer(name).map(|layer| layer.values());
    let albedo = layer("albedo");
    // The library knows no pictures with normals alone.
    let features = [(c"albedo", albedo), (c"normal", albedo.and_then(|_| layer("normal")))];
    let mut outputs = colors.map(|color| vec![[0.0; 3]; color.len()]);
    // SAFETY: `set` checks that each image has `width` × `height` values of three floats, and all of them outlive the
    // filter, which writes only to the outputs. Device and filter are used by this thread alone until they are released.
    unsafe {
        let device = functions.device(rayon::current_num_threads() as c_int)?;
        let filter = (functions.new_filter)(device, c"RT".as_ptr());
        let set = |name: &CStr, values: *mut [[f32; 3]]| {
            assert_eq!(values.len(), count, "one value per pixel");
            let (name, values) = (name.as_ptr(), values.cast());
            (functions.set_image)(filter, name, values, THREE_FLOATS, width, height, 0, 0, 0);
        };
        for (name, values) in features {
            if let Some(values) = values {
                set(name, std::ptr::from_ref(values).cast_mut());
            }
        }
        (functions.set_filter_bool)(filter, c"hdr".as_ptr(), true);
        for (color, output) in colors.into_iter().zip(&mut outputs) {
            set(c"color", std::ptr::from_ref(color).cast_mut());
            set(c"output", &raw mut output[..]);
            (functions.commit_filter)(filter);
            (functions.execute_filter)(filter);
        }
        let done = functions.check(device);
        (functions.release_filter)(filter);
        (functions.release_device)(device);
        done?;
    }
    for value in outputs.iter_mut().flatten().flatten() {
        *value = value.most(0.0);
    }
    Ok(outputs)
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
        let place = place()?;
        // The source says more than the error, and mostly names the file.
        let reason = |error: libloading::Error| {
            let reason = error.source().map_or_else(|| error.to_string(), ToString::to_string);
            let file = place.display().to_string();
            if reason.contains(&file) { reason } else { format!("{file}: {reason}") }
        };
        // SAFETY: the library is the one that the user chose. It stays loaded, since its threads may outlive a device.
        let functions = unsafe {
            let library = open(&place).map_err(|error| fails(reason(error)))?;
            let functions = Functions::find(&library);
            std::mem::forget(library);
            functions.map_err(|error| fails(format!("another version? {}", reason(error))))?
        };
        // SAFETY: the device is used by this thread alone until it is released.
        let version = unsafe {
            let device = functions.device(1);
            let device = device.map_err(|error| fails(format!("{}: {error}", place.display())))?;
            let version = (functions.get_device_int)(device, c"version".as_ptr());
            (functions.release_device)(device);
            version
        };
        match version {
            VERSION_2..VERSION_3 => Ok(Self { functions, version }),
            _ => Err(fails(format!("{}: another version, {}", place.display(), named(version)))),
        }
    }
}

impl Functions {
    /// A new device of so many threads.
    ///
    /// # Safety
    /// The functions must be those of the library.
    unsafe fn device(&self, threads: c_int) -> Result<Device> {
        // SAFETY: the library allows all of these calls for any device, even none.
        unsafe {
            let device = (self.new_device)(CPU);
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
fn place() -> Result<PathBuf> {
    let Some(value) = env::var_os(VARIABLE).filter(|value| !value.is_empty()) else {
        return Ok(PathBuf::from(FILE));
    };
    let given = PathBuf::from(value);
    // The system would look for a file without a folder elsewhere.
    let path = std::path::absolute(&given).map_err(Error::io(&given, "find"))?;
    Ok(if path.is_dir() { path.join(FILE) } else { path })
}

/// # Safety
/// The library's initialisation must be sound.
unsafe fn open(place: &Path) -> Result<Library, libloading::Error> {
    // The libraries that it needs are beside it.
    #[cfg(windows)]
    if place.is_absolute() {
        use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
        // SAFETY: the caller's.
        return unsafe { Library::load_with_flags(place, LOAD_WITH_ALTERED_SEARCH_PATH) }
            .map(Into::into);
    }
    // SAFETY: the caller's.
    unsafe { Library::new(place) }
}
