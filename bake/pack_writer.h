/* A rock_set to the bytes of a pack (runtime/pack_format.h). */
#ifndef SCREE_PACK_WRITER_H
#define SCREE_PACK_WRITER_H

#include "rock_set.h"

/* Lays out and fills a pack. The same set gives the same bytes; nothing of it is kept.
 * bytes, size: the pack, owned by the caller: scree_rt_release(allocator, bytes, size, 1).
 * Returns SCREE_OK, OUT_OF_MEMORY, INVALID_ARGUMENT (a set that breaks a rule of the format: rocks out of order, a hull of fewer
 * than 4 or more than 64 vertices, a number that is not finite) or RANGE (more than the format can count). On failure nothing is
 * owned. */
scree_result pack_write(const rock_set* set, const scree_allocator* allocator, uint8_t** bytes, size_t* size);

/* The digest of a pack that pack_write made. */
uint64_t pack_bytes_digest(const uint8_t* bytes);

#endif
