/* The host's allocator, with overflow checks in one place. Shared by runtime/ and bake/. */
#ifndef SCREE_ALLOCATOR_H
#define SCREE_ALLOCATOR_H

#include <scree/base.h>

#define SCREE_ALIGNMENT 64

/* *given if it has an alloc function, malloc and free otherwise. */
scree_allocator scree_rt_allocator_or_default(const scree_allocator* given);

/* count * size bytes, aligned to SCREE_ALIGNMENT, or NULL when that overflows or memory is short. */
void* scree_rt_allocate(const scree_allocator* allocator, size_t count, size_t size);
void* scree_rt_allocate_zeroed(const scree_allocator* allocator, size_t count, size_t size);

/* Gives back what allocate returned for the same count and size; NULL is allowed. */
void scree_rt_release(const scree_allocator* allocator, void* memory, size_t count, size_t size);

#endif
