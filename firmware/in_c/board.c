/* The start of a C program on QEMU's MPS2 boards, and its output to the emulator over semihosting. For a real board
   use the start-up code of its manufacturer. */
#include "board.h"

#include <stddef.h>

extern uint32_t data_load[], data_begin[], data_end[], bss_begin[], bss_end[], stack_top[];
int main(void);
void reset(void);
static void fault(void);

/* The first vectors: the stack, the start, and faults from NMI to UsageFault. */
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    stack_top, reset, fault, fault, fault, fault, fault,
};

static volatile uint32_t *const timer = (volatile uint32_t *)0xE000E010; /* control, reload, value */
static const uint32_t largest_count = 0x00ffffff;
static uint32_t empty;

void reset(void) {
#ifdef __ARM_FP
  /* The floating-point unit is off after a reset. */
  *(volatile uint32_t *)0xE000ED88 |= 0xf << 20;
  __asm__ volatile("dsb\nisb" ::: "memory");
#endif
  const uint32_t *from = data_load;
  for (uint32_t *to = data_begin; to < data_end; to++) *to = *from++;
  for (uint32_t *to = bss_begin; to < bss_end; to++) *to = 0;
  leave(main() == 0);
}

static uintptr_t ask(uintptr_t what, uintptr_t parameter) {
  register uintptr_t r0 __asm__("r0") = what;
  register uintptr_t r1 __asm__("r1") = parameter;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

_Noreturn void leave(int is_well) {
  /* "The application ends", or "a run-time error". */
  ask(0x18, is_well ? 0x20026 : 0x20023);
  for (;;) {
  }
}

void say(const char *text) {
  static uintptr_t out;
  if (out == 0) {
    /* The emulator's standard output is a file of that name, open for writing. */
    const uintptr_t open[] = {(uintptr_t) ":tt", 4, 3};
    out = ask(0x01, (uintptr_t)open);
  }
  uintptr_t length = 0;
  while (text[length] != '\0') length++;
  const uintptr_t write[] = {out, (uintptr_t)text, length};
  ask(0x05, (uintptr_t)write);
}

static void fault(void) {
  say("a fault of the processor\n");
  leave(0);
}

/* In firmware: disables the motors. Here the emulator ends. */
void palpate_panicked(void) {
  say("the library has panicked\n");
  leave(0);
}

void start_counting(void) {
  timer[1] = largest_count;
  timer[2] = 0;
  timer[0] = 5; /* the clock of the processor, counting */
  empty = 0;
  const uint32_t before = reading();
  empty = instructions_between(before, reading());
}

__attribute__((noinline)) uint32_t reading(void) { return timer[2]; }

uint32_t instructions_between(uint32_t before, uint32_t after) {
  const uint32_t tenths = 10 * ((before - after) & largest_count);
  const uint32_t instructions = (tenths + 32) / 64;
  return instructions > empty ? instructions - empty : 0;
}
