/* scree-bench-pack [NAME]: what opening a pack costs, one JSON object a line, for ./dev bench: allocations, and bytes touched in
 * pages, seen by protecting the pack's memory. The reference is a pack with a fifteenth of the assets; a ratio of 1 is no growth.
 */
#define _GNU_SOURCE
#include <scree/pack.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "make_pack.h"

static uint8_t* guarded;
static size_t guarded_size, page;
static volatile sig_atomic_t pages;

static void on_fault(int signal, siginfo_t* info, void* context) {
  (void)context;
  uint8_t* at = (uint8_t*)info->si_addr;
  if (signal != SIGSEGV || at < guarded || at >= guarded + guarded_size) _exit(1);
  mprotect(guarded + (size_t)(at - guarded) / page * page, page, PROT_READ);
  ++pages;
}

typedef struct counter {
  uint64_t allocations, bytes;
} counter;

static void* count_alloc(void* user, size_t size) {
  counter* c = user;
  ++c->allocations;
  c->bytes += size;
  return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void count_release(void* user, void* memory, size_t size) {
  (void)user;
  (void)size;
  free(memory);
}

typedef struct cost {
  double assets, allocations, allocated, touched;
} cost;

static cost measure(const test_pack_desc* desc) {
  size_t size;
  uint8_t* bytes = test_pack_make(desc, &size);
  guarded_size = (size + page - 1) / page * page;
  /* cppcheck-suppress invalidFunctionArg ; no file: that is what -1 says */
  guarded = mmap(NULL, guarded_size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (guarded == MAP_FAILED) exit(1);
  memcpy(guarded, bytes, size);
  free(bytes);
  mprotect(guarded, guarded_size, PROT_NONE);
  pages = 0;
  counter counted = {0, 0};
  const scree_allocator allocator = {count_alloc, count_release, &counted};
  scree_pack* pack;
  if (scree_pack_open_memory(guarded, size, &allocator, &pack) != SCREE_OK) exit(1);
  const double touched = (double)pages * (double)page;
  scree_pack_info info;
  scree_pack_get_info(pack, &info);
  scree_pack_close(pack);
  munmap(guarded, guarded_size);
  return (cost){info.asset_count, (double)counted.allocations, (double)counted.bytes, touched};
}

static void print_row(const char* prefix, const char* name, double value, const char* unit, double reference) {
  if (strncmp(name, prefix, strlen(prefix)) != 0) return;
  printf("{\"name\": \"%s\", \"value\": %.6g, \"unit\": \"%s\", \"reference\": %g, \"ratio\": %.4g}\n", name, value, unit,
         reference, reference / value);
}

int main(int count, char** arguments) {
  const char* prefix = count > 1 ? arguments[1] : "";
  page = (size_t)sysconf(_SC_PAGESIZE);
  struct sigaction action = {.sa_sigaction = on_fault, .sa_flags = SA_SIGINFO};
  sigaction(SIGSEGV, &action, NULL);
  const test_pack_desc few = {.cells_per_cube = 3}, many = {.cells_per_cube = 3, .rocks_per_cell = 29};
  const cost small = measure(&few), large = measure(&many);
  fprintf(stderr, "packs of %.0f and %.0f assets\n", small.assets, large.assets);
  print_row(prefix, "pack.open_allocations", large.allocations, "calls", small.allocations);
  print_row(prefix, "pack.open_allocated", large.allocated, "bytes", small.allocated);
  print_row(prefix, "pack.open_touched", large.touched, "bytes", small.touched);
  return 0;
}
