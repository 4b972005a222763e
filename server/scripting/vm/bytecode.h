// bytecode: finds what a compiled function does that no budget and no read-only table can stop.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace zoned::scripting {

struct BytecodeFinding {
    int line = 0;
    std::string text;
};

/// `dump`: a function as lua_dump writes it, with its debug information. `outlives`: the function
/// is kept after the file has run, and so are the locals of others that it writes to: they would be
/// state that no save keeps. Raising to a power is reported in either case: pow() differs between
/// machines. Reports of functions within it as well. Bytes of another version are a finding, too.
std::vector<BytecodeFinding> inspect_bytecode(std::string_view dump, bool outlives);

}  // namespace zoned::scripting
