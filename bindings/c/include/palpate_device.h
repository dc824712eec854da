/* A device of your own for palpate: a shared library with these functions, loaded at run time by
 *
 *     palpate run SCENE.toml --device plugin:./libmine.so        or plugin:./libmine.so,ARGUMENT
 *
 * MIT or Apache-2.0, at your option.
 *
 * Units are SI; vectors are in the frame of the device, with 0 on axes that it lacks. The functions are called by one thread
 * at a time, not always the same, except palpate_device_zero. They must not throw, and read and write must return within
 * a small part of the loop's period. */
#ifndef PALPATE_DEVICE_H
#define PALPATE_DEVICE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32)
#define PALPATE_DEVICE_API __declspec(dllexport)
#elif defined(__GNUC__)
#define PALPATE_DEVICE_API __attribute__((visibility("default")))
#else
#define PALPATE_DEVICE_API
#endif

/* Version of this interface. */
#define PALPATE_DEVICE_VERSION 1u

/* Results. */
#define PALPATE_DEVICE_OK 0
#define PALPATE_DEVICE_NOTHING_NEW 1  /* read: no new sample; the loop keeps the force for one period, then commands 0 */
#define PALPATE_DEVICE_DISCONNECTED 2 /* the device is gone: the loop ends */
#define PALPATE_DEVICE_REFUSED 3      /* the device rejects: the loop commands 0 until it works again */

/* Capabilities of the device. 0 in a double means unknown. */
typedef struct PalpateDeviceCapabilities {
    uint32_t size;             /* sizeof(PalpateDeviceCapabilities), set by the caller */
    uint32_t axes;             /* axes with a position and a force, 1 to 3 */
    uint32_t torque_axes;      /* axes with a torque, 0 to 3; 0 without an orientation */
    uint32_t has_orientation;  /* 1: samples have an orientation */
    uint32_t holds_last_force; /* 1: it holds the last force if this process is killed */
    uint32_t reserved;         /* 0 */
    double largest_force_n;    /* larger forces are shortened [N] */
    double largest_torque_n_m; /* [N m] */
    double largest_stiffness_n_per_m;
    double largest_damping_n_s_per_m;
    double mass_kg;   /* effective mass at the end-point */
    double quantum_m; /* quantum of the position */
} PalpateDeviceCapabilities;

/* A sample. */
typedef struct PalpateDeviceSample {
    uint32_t size;         /* sizeof(PalpateDeviceSample), set by the caller */
    uint32_t has_time;     /* 1: time_s is the sampling time; 0: the sample is of now */
    double time_s;         /* on any monotonic clock [s] */
    double position_m[3];  /* [m] */
    double orientation[4]; /* unit quaternion w, x, y, z, with has_orientation */
} PalpateDeviceSample;

/* A force and a torque on the end-point. */
typedef struct PalpateDeviceWrench {
    uint32_t size; /* sizeof(PalpateDeviceWrench), set by the caller */
    uint32_t reserved;
    double force_n[3];    /* [N] */
    double torque_n_m[3]; /* [N m] */
} PalpateDeviceWrench;

/* Your device. The library defines the structure as it likes. */
typedef struct PalpateDevice PalpateDevice;

/* The two functions that tell which header the library was compiled with: write PALPATE_DEVICE_IDENTITY once. */
PALPATE_DEVICE_API uint32_t palpate_device_version(void);
PALPATE_DEVICE_API uint32_t palpate_device_size(uint32_t structure);

#define PALPATE_DEVICE_IDENTITY                                                                                        \
    uint32_t palpate_device_version(void) { return PALPATE_DEVICE_VERSION; }                                           \
    uint32_t palpate_device_size(uint32_t structure) {                                                                 \
        return structure == 0u   ? (uint32_t)sizeof(PalpateDeviceCapabilities)                                         \
               : structure == 1u ? (uint32_t)sizeof(PalpateDeviceSample)                                               \
               : structure == 2u ? (uint32_t)sizeof(PalpateDeviceWrench)                                               \
                                 : 0u;                                                                                 \
    }

/* Opens the device and sets *device. The argument is the text after the comma of the flag, or empty. */
PALPATE_DEVICE_API int palpate_device_open(const char *argument, PalpateDevice **device);

/* Name of the device, for reports; it lasts until close. */
PALPATE_DEVICE_API const char *palpate_device_name(PalpateDevice *device);

/* Last error in words, or a null pointer; it lasts until the next call. A null device: the error of open. */
PALPATE_DEVICE_API const char *palpate_device_error(PalpateDevice *device);

/* Fills *capabilities, which stay constant. */
PALPATE_DEVICE_API int palpate_device_capabilities(PalpateDevice *device, PalpateDeviceCapabilities *capabilities);

/* Fills *sample. */
PALPATE_DEVICE_API int palpate_device_read(PalpateDevice *device, PalpateDeviceSample *sample);

/* Commands *wrench until the next call. *held begins as a copy of it: a device that clamps writes what it really holds. */
PALPATE_DEVICE_API int palpate_device_write(PalpateDevice *device, const PalpateDeviceWrench *wrench,
                                            PalpateDeviceWrench *held);

/* Optional: commands zero force from another thread while read or write hangs, and returns at once. */
PALPATE_DEVICE_API void palpate_device_zero(PalpateDevice *device);

/* Commands zero force and closes the device. */
PALPATE_DEVICE_API void palpate_device_close(PalpateDevice *device);

#ifdef __cplusplus
}
#endif

#endif
