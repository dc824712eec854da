/* Functions of a C program on QEMU's MPS2 boards: text output to the emulator, the end of the emulation, and an
   instruction count. */
#pragma once

#include <stdint.h>

/* Writes `text`, ended by a 0. */
void say(const char *text);

/* Ends the emulator: with 0 if all is well, with 1 if not. */
_Noreturn void leave(int is_well);

/* Starts the timer that counts instructions. With QEMU's `-icount shift=8` each takes 256 ns, and the timer counts
   at 25 MHz: 6.4 counts. */
void start_counting(void);

/* A reading of the timer, which counts down. */
uint32_t reading(void);

/* Instructions between two readings, at most 2.6 million, without those of the readings themselves. */
uint32_t instructions_between(uint32_t before, uint32_t after);
