/* How often a test repeats what is random. A sanitizer makes a round many times slower, and is there for faults of memory and
 * threads, which turn up in the first rounds or never; wrong answers are for the builds without one, which run all of them. */
#ifndef SCREE_TESTS_ROUNDS_H
#define SCREE_TESTS_ROUNDS_H

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SCREE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SCREE_SANITIZED 1
#endif
#endif

/* `all`, or under a sanitizer one of `part`, rounded up: of rounds, and of what they must have met in the end. */
#ifdef SCREE_SANITIZED
#define ROUNDS(all, part) (((all) + (part)-1) / (part))
#else
#define ROUNDS(all, part) (all)
#endif

#endif
