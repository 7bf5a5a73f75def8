/* libdraco's own decoding, without what we add to it. */
#ifndef SCREE_TESTS_BENCH_LIBDRACO_H
#define SCREE_TESTS_BENCH_LIBDRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Decodes a blob of any make-up and throws the mesh away. Returns whether libdraco took it. */
bool bench_libdraco_decode(const uint8_t* blob, size_t size);

#ifdef __cplusplus
}
#endif

#endif
