// Way bytes: the ways of all minds of a zone written down and read again, beside mind bytes.
#pragma once

#include "server/ai/ai_step.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai {

/// Appends who has asked for a way and what has become of it, between two ticks: little endian,
/// after a version and counts. The maps themselves are baked anew.
void write_ways(const Ways& ways, std::vector<std::uint8_t>& out);

/// Reads what write_ways() wrote into `ways` that were just made for the same ground, with doors as
/// they were, after `minds` and their `step` were read. Empty text: done, and minds go on bit for
/// bit (but see navigation::WayMemory). Otherwise it says what is wrong, with the way: another
/// version, cut short, bytes left over, or numbers that mean nothing to these maps and minds; then
/// the ways are of no use, and minds may be given new ones: they ask anew.
std::string read_ways(std::span<const std::uint8_t> bytes,
                      const Minds& minds,
                      Ways& ways,
                      Step& step);

}  // namespace zoned::ai
