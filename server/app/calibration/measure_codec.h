// Measured codec price: times on this machine the coding of records for one client alone.
#pragma once

#include "server/mailbox/messages.h"

namespace zoned::app {

/// Codes packets of a few and of many walkers that turn now and then, for two dozen clients by
/// turns, acknowledged as on a good network. Draws a line through the CPU times; of three runs of
/// each the median counts. Takes about 100 ms. For a world whose codec is chosen by cost
/// (replication::Codec::kAuto). The price then goes to all zones as an item of their inbox, and so
/// into recordings.
mailbox::CodecPrice measure_codec();

}  // namespace zoned::app
