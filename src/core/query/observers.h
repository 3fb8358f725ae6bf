// Those who look at a world and change nothing in it: what is published for a renderer, the grids that queries are
// answered from, the events of a step, the list of contacts, the columns of bodies.
//
// None of them owns memory before somebody asks. The world tells them what changed.
#pragma once

#include "query/contact_list.h"
#include "query/events.h"
#include "query/query_index.h"
#include "query/readout.h"

namespace psim {

struct Observers {
  Publisher publisher;
  QueryIndex queries;
  EventList events;
  ContactList contacts;
  PublishedColumns columns;
  bool placed = true;  ///< the host added or moved bodies since the last step

  std::size_t bytes() const {
    return publisher.bytes() + queries.bytes() + events.bytes() + contacts.bytes() + columns.bytes();
  }
};

}  // namespace psim
