// Frame pool: reuses coded frames that nothing holds any more, with the memory of their columns.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace zoned::wire::entropy {

/// A Frame has clear(), which empties it but keeps its memory. A copy of a pool is independent.
template <class Frame>
class FramePool {
  public:
    FramePool() = default;

    FramePool(const FramePool& /*other*/) {}

    FramePool& operator=(const FramePool& /*other*/) { return *this; }

    /// Empty but for the memory of its columns.
    std::shared_ptr<Frame> take() {
        for (std::size_t tries = 0; tries < frames_.size(); ++tries) {
            next_ = (next_ + 1) % frames_.size();
            if (frames_[next_].use_count() == 1) {
                frames_[next_]->clear();
                return frames_[next_];
            }
        }
        return frames_.emplace_back(std::make_shared<Frame>());
    }

  private:
    std::vector<std::shared_ptr<Frame>> frames_;
    std::size_t next_ = 0;
};

}  // namespace zoned::wire::entropy
