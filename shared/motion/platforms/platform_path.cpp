#include "shared/motion/platforms/platform_path.h"

#include <algorithm>
#include <cmath>

namespace zoned::motion {

float on_platform_step(double metres) {
    return static_cast<float>(std::floor(metres / kPlatformStep_m + 0.5) * kPlatformStep_m);
}

Tick PlatformPath::period() const {
    const auto count = static_cast<Tick>(stops.size());
    return back > 0 ? length() + count * wait : 2 * length() + (2 * count - 2) * wait;
}

Tick PlatformPath::along_at(Tick tick) const {
    // The remainder first: so nothing overflows, whatever the tick.
    const Tick whole = period();
    const Tick shifted = tick % whole + shift % whole;
    Tick phase = shifted < 0 ? shifted + whole : shifted % whole;
    for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
        if (phase < wait) {
            return stops[i].at;
        }
        phase -= wait;
        if (phase < stops[i + 1].at - stops[i].at) {
            return stops[i].at + phase;
        }
        phase -= stops[i + 1].at - stops[i].at;
    }
    if (back > 0) {
        return stops.back().at + std::max<Tick>(0, phase - wait);
    }
    for (std::size_t i = stops.size() - 1; i > 0; --i) {
        if (phase < wait) {
            return stops[i].at;
        }
        phase -= wait;
        if (phase < stops[i].at - stops[i - 1].at) {
            return stops[i].at - phase;
        }
        phase -= stops[i].at - stops[i - 1].at;
    }
    return 0;
}

Vec3 PlatformPath::offset(Tick along) const {
    const auto next = std::upper_bound(
        stops.begin(), stops.end(), along, [](Tick t, const PlatformStop& s) { return t < s.at; });
    const PlatformStop& begin = *std::prev(next);
    if (begin.at == along) {
        return begin.offset;
    }
    const bool last = next == stops.end();  // on the way straight back
    const PlatformStop& end = last ? stops.front() : *next;
    const Tick ticks = (last ? length() : end.at) - begin.at;
    const double share = static_cast<double>(along - begin.at) / static_cast<double>(ticks);
    Vec3 out;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<double>(begin.offset[axis]);
        const auto b = static_cast<double>(end.offset[axis]);
        out[axis] = on_platform_step(a + (b - a) * share);
    }
    return out;
}

Tick PlatformCourse::along_at(Tick tick) const {
    const Tick most = std::max<Tick>(0, tick - from);
    return along + std::clamp(to - along, -most, most);
}

}  // namespace zoned::motion
