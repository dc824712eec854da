/* A device of one's own as a shared library: here a mass of 0.2 kg that a spring holds 5 mm in the wall.
 *
 *     cc -shared -fPIC -I bindings/c/include examples/own_device/my_device.c -o libmine.so
 *     palpate run experiments/wall.toml --method basic --device plugin:./libmine.so */
#include <palpate_device.h>
#include <stdlib.h>

struct PalpateDevice {
    double force, position, velocity;
};

PALPATE_DEVICE_IDENTITY

int palpate_device_open(const char *argument, PalpateDevice **device) {
    (void)argument;
    *device = calloc(1, sizeof **device);
    return *device ? PALPATE_DEVICE_OK : PALPATE_DEVICE_REFUSED;
}

const char *palpate_device_name(PalpateDevice *device) {
    (void)device;
    return "my device";
}

const char *palpate_device_error(PalpateDevice *device) {
    return device ? 0 : "no memory";
}

int palpate_device_capabilities(PalpateDevice *device, PalpateDeviceCapabilities *can) {
    (void)device;
    can->axes = 1;
    can->largest_force_n = 5.0;
    can->mass_kg = 0.2;
    return PALPATE_DEVICE_OK;
}

int palpate_device_read(PalpateDevice *device, PalpateDeviceSample *sample) {
    /* Replace these lines by your sensor. */
    double pull = 500.0 * (0.005 - device->position) - 10.0 * device->velocity;
    device->velocity += (device->force + pull) / 0.2 * 0.001;
    device->position += device->velocity * 0.001;
    sample->position_m[0] = device->position;
    return PALPATE_DEVICE_OK;
}

int palpate_device_write(PalpateDevice *device, const PalpateDeviceWrench *wrench, PalpateDeviceWrench *held) {
    (void)held;
    device->force = wrench->force_n[0]; /* to your motor */
    return PALPATE_DEVICE_OK;
}

void palpate_device_close(PalpateDevice *device) {
    free(device);
}
