// Snapshot codec: codes whole snapshots for one client in few bits, against snapshots that this
// client has acknowledged.
// Reached by no program yet: recordings, and worlds in which a client receives every state, will
// use it.
#pragma once

#include "shared/core/result.h"
#include "shared/wire/snapshot/knowledge.h"
#include "shared/wire/snapshot/neighbours.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::wire::snapshot {

/// Codes snapshots exactly, each against the newest acknowledged ones. The prediction uses velocity
/// over several lags, turn rate, and the motion of neighbours that are coded already. Least squares
/// learn its weights; an adaptive range coder codes the residuals. Predictors and probabilities are
/// trained on acknowledged snapshots only, in ascending order, so any packet may be lost, doubled
/// or late. After R. Giesen's contest entry (adaptive models inherited from the acknowledged
/// baseline, 2015), which has neither neighbours nor least squares and trains on one snapshot in as
/// many as are in flight.
class SnapshotEncoder {
  public:
    explicit SnapshotEncoder(const SnapshotFormat& format);

    /// Appends the code of snapshot `number` (ascending from 1) to `out`. Samples must be within
    /// the format; one per body.
    void encode(FrameNumber number, const Snapshot& samples, std::vector<std::uint8_t>& out);

    /// The receiver has decoded this snapshot. Unknown, old and repeated numbers are ignored.
    void acknowledge(FrameNumber number);

    /// A snapshot that the receiver got in another way (at login); before the first encode().
    void share(FrameNumber number, const Snapshot& samples);

  private:
    SnapshotFormat format_;
    entropy::KnowledgeEncoder<Knowledge> acknowledged_;
    Neighbours neighbours_;  // of the pass
    entropy::FramePool<CodedFrame> frames_;
    std::vector<std::uint8_t> raw_;  // scratch of the range coder
};

class SnapshotDecoder {
  public:
    explicit SnapshotDecoder(const SnapshotFormat& format);

    /// Decodes snapshot `number`. Bytes are hostile: fails with the reason, and without any change,
    /// when they are malformed or refer to unknown snapshots. Each decoded snapshot must be
    /// acknowledged to the encoder, and no other. The samples stay valid until the next decode().
    core::Result<const Snapshot*> decode(FrameNumber number, std::span<const std::uint8_t> bytes);

    void share(FrameNumber number, const Snapshot& samples);

  private:
    SnapshotFormat format_;
    entropy::KnowledgeDecoder<Knowledge> acknowledged_;
    Neighbours neighbours_;  // of the pass
    entropy::FramePool<CodedFrame> frames_;
};

}  // namespace zoned::wire::snapshot
