#include "server/scripting/vm/bytecode.h"

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace zoned::scripting {

namespace {

// Lua 5.4's format (ldump.c) and the opcodes (lopcodes.h) that matter here.
constexpr std::string_view kHeader("\x1bLua\x54\x00\x19\x93\r\n\x1a\n\x04\x08\x08", 15);
constexpr std::size_t kCheckNumberBytes = 16;  // an integer and a float of known values
constexpr std::uint32_t kOpMask = 0x7F;
constexpr std::uint32_t kSetUpvalue = 10;
constexpr std::uint32_t kPowerConstant = 26;
constexpr std::uint32_t kPower = 38;
constexpr unsigned kArgumentB = 16;
constexpr int kAbsoluteLine = -0x80;

struct Upvalue {
    bool local_of_parent = false;
    std::uint8_t index = 0;  ///< of the parent's locals or upvalues
};

struct Function {
    int line = 0;
    std::vector<std::uint32_t> code;
    std::vector<Upvalue> upvalues;
    std::vector<Function> inner;
    std::vector<int> lines;  ///< of each instruction
    std::vector<std::string> upvalue_names;
};

/// Throws std::out_of_range where the bytes end too early.
class DumpReader {
  public:
    explicit DumpReader(std::string_view bytes) : bytes_(bytes) {}

    std::string_view take(std::size_t count) {
        if (count > bytes_.size()) {
            throw std::out_of_range("dump");
        }
        const std::string_view some = bytes_.substr(0, count);
        bytes_.remove_prefix(count);
        return some;
    }

    std::uint8_t byte() { return static_cast<std::uint8_t>(take(1)[0]); }

    /// Seven bits a byte, the highest first; the last byte has its top bit set.
    std::size_t size() {
        std::size_t value = 0;
        for (;;) {
            const std::uint8_t next = byte();
            value = (value << 7U) | (next & 0x7FU);
            if ((next & 0x80U) != 0) {
                return value;
            }
        }
    }

    /// Its length is one more than its bytes; 0: none.
    std::string_view text() {
        const std::size_t length = size();
        return length == 0 ? std::string_view() : take(length - 1);
    }

    void skip_constant() {
        enum : std::uint8_t {
            kInteger = 0x03,
            kFloat = 0x13,
            kShortText = 0x04,
            kLongText = 0x14
        };

        const std::uint8_t kind = byte();
        if (kind == kInteger || kind == kFloat) {
            take(8);
        } else if (kind == kShortText || kind == kLongText) {
            text();
        }
    }

    Function function() {
        Function out;
        text();  // its source
        out.line = static_cast<int>(size());
        size();   // its last line
        take(3);  // parameters, whether there are more, registers
        out.code.resize(size());
        const std::string_view code = take(out.code.size() * sizeof(std::uint32_t));
        std::memcpy(out.code.data(), code.data(), code.size());
        for (std::size_t n = size(); n > 0; --n) {
            skip_constant();
        }
        for (std::size_t n = size(); n > 0; --n) {
            const std::string_view upvalue = take(3);
            out.upvalues.push_back({upvalue[0] != 0, static_cast<std::uint8_t>(upvalue[1])});
        }
        for (std::size_t n = size(); n > 0; --n) {
            out.inner.push_back(function());
        }
        read_lines(out);
        for (std::size_t n = size(); n > 0; --n) {
            text();  // a local: name, and the instructions between which it lives
            size();
            size();
        }
        for (std::size_t n = size(); n > 0; --n) {
            out.upvalue_names.emplace_back(text());
        }
        return out;
    }

  private:
    void read_lines(Function& out) {
        const std::string_view steps = take(size());
        std::vector<std::pair<std::size_t, int>> absolute(size());
        for (auto& [at, line] : absolute) {
            at = size();
            line = static_cast<int>(size());
        }
        int line = out.line;
        std::size_t next = 0;
        for (const char step : steps) {
            if (static_cast<signed char>(step) == kAbsoluteLine && next < absolute.size()) {
                line = absolute[next++].second;
            } else {
                line += static_cast<signed char>(step);
            }
            out.lines.push_back(line);
        }
    }

    std::string_view bytes_;
};

class Inspection {
  public:
    explicit Inspection(bool outlives) : outlives_(outlives) {}

    /// `around`: the functions that this one lies in, the outermost first.
    void visit(const Function& function, std::vector<const Function*>& around) {
        around.push_back(&function);
        for (std::size_t i = 0; i < function.code.size(); ++i) {
            const std::uint32_t op = function.code[i] & kOpMask;
            const int line = i < function.lines.size() ? function.lines[i] : function.line;
            if (op == kPower || op == kPowerConstant) {
                findings.push_back(
                    {line, "'^' differs between processors: multiply, or use math.sqrt"});
            }
            const std::size_t upvalue = (function.code[i] >> kArgumentB) & 0xFFU;
            if (op == kSetUpvalue && outlives_ && outlives(around, upvalue)) {
                findings.push_back({line, text_of(function, upvalue)});
            }
        }
        for (const Function& inner : function.inner) {
            visit(inner, around);
        }
        around.pop_back();
    }

    std::vector<BytecodeFinding> findings;

  private:
    /// A local of a function around it dies with that one's call; one from outside does not.
    static bool outlives(const std::vector<const Function*>& around, std::size_t upvalue) {
        for (std::size_t depth = around.size(); depth-- > 0;) {
            if (upvalue >= around[depth]->upvalues.size()) {
                return true;
            }
            if (depth == 0) {
                return true;
            }
            if (around[depth]->upvalues[upvalue].local_of_parent) {
                return false;
            }
            upvalue = around[depth]->upvalues[upvalue].index;
        }
        return true;
    }

    static std::string text_of(const Function& function, std::size_t upvalue) {
        const std::string name = upvalue < function.upvalue_names.size()
                                     ? function.upvalue_names[upvalue]
                                     : std::string("?");
        return "writes to '" + name +
               "', a local that outlives the call and that no save keeps: keep it in state";
    }

    bool outlives_;
};

}  // namespace

std::vector<BytecodeFinding> inspect_bytecode(std::string_view dump, bool outlives) {
    try {
        DumpReader reader(dump);
        if (reader.take(kHeader.size()) != kHeader) {
            throw std::out_of_range("header");
        }
        reader.take(kCheckNumberBytes);
        reader.byte();  // number of upvalues
        const Function function = reader.function();
        Inspection inspection(outlives);
        std::vector<const Function*> around;
        inspection.visit(function, around);
        return std::move(inspection.findings);
    } catch (const std::out_of_range&) {
        return {{0, "this server's Lua writes bytecode in another form than 5.4's"}};
    }
}

}  // namespace zoned::scripting
