//! The foreign calls into Open Image Denoise, behind types that are safe to use.
//!
//! The crate's own wrapper is avoided on purpose: it copies the images, cannot prefilter, cancel or limit its threads,
//! and its `clean_aux` sets a parameter that the library does not know.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::ffi::{CStr, c_void};
use std::marker::PhantomData;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use oidn::sys;

use super::request::{DenoiseError, DenoiseQuality};
use super::running::{Running, begin, is_over};

/// The settings that all filters of one picture share.
pub struct Job<'a> {
    pub width: usize,
    pub height: usize,
    pub quality: DenoiseQuality,
    pub cancel: &'a AtomicBool,
}

#[derive(Clone, Copy)]
pub enum Auxiliary {
    Albedo,
    Normal,
}

impl Auxiliary {
    fn slot(self) -> &'static CStr {
        match self {
            Self::Albedo => c"albedo",
            Self::Normal => c"normal",
        }
    }
}

/// A committed device on the CPU. Never null.
pub struct Device {
    handle: sys::OIDNDevice,
    _running: Running,
}

impl Device {
    /// Makes a device with at most this many threads, one for each core if `None`. They are not pinned to cores, since
    /// other threads render at the same time.
    pub fn new(threads: Option<usize>) -> Result<Self, DenoiseError> {
        let _running = begin().ok_or(DenoiseError::Cancelled)?;
        // SAFETY: takes no pointer; null is handled below.
        let handle = unsafe { sys::oidnNewDevice(sys::OIDNDeviceType_OIDN_DEVICE_TYPE_CPU) };
        if handle.is_null() {
            let (_, message) = last_error(handle);
            return Err(DenoiseError::NoDevice(message));
        }
        let device = Self { handle, _running };
        // For the library 0 means all cores.
        let threads = threads.map_or(0, |count| i32::try_from(count.max(1)).unwrap_or(i32::MAX));
        // SAFETY: the handle is alive until `device` is dropped; the names end in a zero byte.
        unsafe {
            sys::oidnSetDeviceBool(handle, c"setAffinity".as_ptr(), false);
            sys::oidnSetDeviceInt(handle, c"numThreads".as_ptr(), threads);
            sys::oidnCommitDevice(handle);
        }
        match last_error(handle) {
            (sys::OIDNError_OIDN_ERROR_NONE, _) => Ok(device),
            (_, message) => Err(DenoiseError::NoDevice(message)),
        }
    }

    /// The denoised version of an image that guides the filter of the colour.
    pub fn filter_auxiliary(&self, job: &Job, slot: Auxiliary, image: &[Vec3]) -> Result<Vec<Vec3>, DenoiseError> {
        let filter = Filter::new(self)?;
        filter.set_input(job, slot.slot(), image)?;
        filter.execute(job)
    }

    /// Filters the colour. `clean` says that albedo and normals are noise-free.
    pub fn filter_color(
        &self,
        job: &Job,
        color: &[Vec3],
        albedo: Option<&[Vec3]>,
        normal: Option<&[Vec3]>,
        clean: bool,
    ) -> Result<Vec<Vec3>, DenoiseError> {
        let filter = Filter::new(self)?;
        filter.set_input(job, c"color", color)?;
        if let Some(albedo) = albedo {
            filter.set_input(job, c"albedo", albedo)?;
        }
        if let Some(normal) = normal {
            filter.set_input(job, c"normal", normal)?;
        }
        filter.set_bool(c"hdr", true);
        filter.set_bool(c"cleanAux", clean && albedo.is_some());
        filter.execute(job)
    }

    /// Filters a lightmap.
    pub fn filter_lightmap(&self, job: &Job, color: &[Vec3]) -> Result<Vec<Vec3>, DenoiseError> {
        let filter = Filter::of_kind(self, c"RTLightmap")?;
        filter.set_input(job, c"color", color)?;
        filter.execute(job)
    }

    /// Returns the error of this thread's calls so far, if any.
    fn check(&self) -> Result<(), DenoiseError> {
        match last_error(self.handle) {
            (sys::OIDNError_OIDN_ERROR_NONE, _) => Ok(()),
            (sys::OIDNError_OIDN_ERROR_CANCELLED, _) => Err(DenoiseError::Cancelled),
            (_, message) => Err(DenoiseError::Failed(message)),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: made by `oidnNewDevice`, released once; filters hold a reference of their own to what they need.
        unsafe { sys::oidnReleaseDevice(self.handle) }
    }
}

/// Fetches and clears the error. For a null device it is the error of creating a device.
fn last_error(device: sys::OIDNDevice) -> (sys::OIDNError, String) {
    let mut message = ptr::null();
    // SAFETY: `device` is null, which is allowed here, or alive; `message` is written before it is read.
    let code = unsafe { sys::oidnGetDeviceError(device, &raw mut message) };
    if message.is_null() {
        return (code, String::from("no reason was given"));
    }
    // SAFETY: a string of the library that ends in a zero byte and lives until the next error; copied at once.
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    (code, text)
}

/// Pixels are passed in place: three floats without padding.
const _: () = assert!(size_of::<Vec3>() == 12);

/// A ray tracing filter. The device and the images that it reads stay borrowed for as long as it lives.
struct Filter<'a> {
    handle: sys::OIDNFilter,
    device: &'a Device,
    /// Makes `'a` invariant: otherwise a filter could be coerced to a shorter lifetime, take an image of that lifetime,
    /// and run after it is gone.
    images: PhantomData<Cell<&'a [Vec3]>>,
}

impl<'a> Filter<'a> {
    fn new(device: &'a Device) -> Result<Self, DenoiseError> {
        Self::of_kind(device, c"RT")
    }

    fn of_kind(device: &'a Device, kind: &CStr) -> Result<Self, DenoiseError> {
        // SAFETY: the device is alive; the name ends in a zero byte.
        let handle = unsafe { sys::oidnNewFilter(device.handle, kind.as_ptr()) };
        device.check()?;
        Ok(Self {
            handle,
            device,
            images: PhantomData,
        })
    }

    fn set_bool(&self, name: &CStr, value: bool) {
        // SAFETY: the filter is alive; the name ends in a zero byte.
        unsafe { sys::oidnSetFilterBool(self.handle, name.as_ptr(), value) }
    }

    fn set_input(&self, job: &Job, slot: &CStr, pixels: &'a [Vec3]) -> Result<(), DenoiseError> {
        // SAFETY: the filter only reads this slot, although the type says `*mut`; the borrow outlives the filter.
        unsafe { self.set_image(job, slot, pixels.as_ptr().cast_mut(), pixels.len()) }
    }

    /// # Safety
    /// `pixels` points to `len` pixels that live until the filter is dropped or the slot is set anew; for the slot
    /// `output` they may be written, and nobody else uses them while the filter runs.
    unsafe fn set_image(&self, job: &Job, slot: &CStr, pixels: *mut Vec3, len: usize) -> Result<(), DenoiseError> {
        // The library trusts the given size.
        if Some(len) != job.width.checked_mul(job.height) {
            return Err(DenoiseError::Failed(format!(
                "{slot:?} does not have the size of the picture"
            )));
        }
        // SAFETY: `len` pixels, as just checked, each of three packed floats; strides of 0 mean packed.
        unsafe {
            sys::oidnSetSharedFilterImage(
                self.handle,
                slot.as_ptr(),
                pixels.cast::<c_void>(),
                sys::OIDNFormat_OIDN_FORMAT_FLOAT3,
                job.width,
                job.height,
                0,
                0,
                0,
            );
        }
        Ok(())
    }

    /// Runs to the end or until cancelled.
    fn execute(self, job: &Job) -> Result<Vec<Vec3>, DenoiseError> {
        let mut output = vec![Vec3::ZERO; job.width * job.height];
        let quality = match job.quality {
            DenoiseQuality::Fast => sys::OIDNQuality_OIDN_QUALITY_FAST,
            DenoiseQuality::Balanced => sys::OIDNQuality_OIDN_QUALITY_BALANCED,
            DenoiseQuality::High => sys::OIDNQuality_OIDN_QUALITY_HIGH,
        };
        let flag = ptr::from_ref(job.cancel).cast_mut().cast::<c_void>();
        // SAFETY: `output` outlives the filter, which this function consumes, and is not touched until the call that
        // fills it has come back (it waits for the end). The flag outlives that call too; it is only ever read through
        // a shared reference to an atomic, so any thread of the library may ask.
        unsafe {
            self.set_image(job, c"output", output.as_mut_ptr(), output.len())?;
            sys::oidnSetFilterInt(self.handle, c"quality".as_ptr(), quality);
            sys::oidnSetFilterProgressMonitorFunction(self.handle, Some(may_go_on), flag);
            sys::oidnCommitFilter(self.handle);
        }
        self.device.check()?;
        // SAFETY: as above; the filter is committed without error.
        unsafe { sys::oidnExecuteFilter(self.handle) };
        self.device.check()?;
        Ok(output)
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `oidnNewFilter`, released once.
        unsafe { sys::oidnReleaseFilter(self.handle) }
    }
}

/// A callback that the library calls from time to time while a filter runs.
///
/// # Safety
/// `flag` points to an `AtomicBool` that is alive.
unsafe extern "C" fn may_go_on(flag: *mut c_void, _done: f64) -> bool {
    // SAFETY: the caller's promise.
    let cancel = unsafe { &*flag.cast::<AtomicBool>() };
    !cancel.load(Ordering::Relaxed) && !is_over()
}
