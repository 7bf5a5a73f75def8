/* The events of an update, and what may still be sent in it. */
#include <string.h>

#include "stream_internal.h"

bool scree_rt_stream_can_send(const scree_stream* s, uint32_t events, uint64_t bytes) {
  return events <= s->desc.caps.events - s->event_count && bytes <= s->desc.caps.upload_bytes - s->upload_bytes;
}

scree_event* scree_rt_stream_send(scree_stream* s, scree_event_kind kind, uint64_t bytes) {
  scree_event* event = &s->events[s->event_count++];
  s->upload_bytes += bytes;
  memset(event, 0, sizeof *event);
  event->kind = kind;
  return event;
}
