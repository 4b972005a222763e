#include "tests/bench/fuzzylite_peer.h"

#include <fl/Headers.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace zoned::bench {

namespace {

using ai::fuzzy::FuzzyDef;
using ai::fuzzy::Inference;
using ai::fuzzy::Rule;

fl::Term* trapezoid(const ai::fuzzy::Term& term, double low, double high) {
    // A shoulder ends where the range does.
    const double a = std::isinf(term.a) ? std::min<double>(low, term.b) : term.a;
    const double b = std::isinf(term.a) ? a : term.b;
    const double d = std::isinf(term.d) ? std::max<double>(high, term.c) : term.d;
    const double c = std::isinf(term.d) ? d : term.c;
    if (b == c) {
        return new fl::Triangle(term.name, a, b, d);
    }
    return new fl::Trapezoid(term.name, a, b, c, d);
}

std::string text_of_rule(const FuzzyDef& def, const Rule& rule) {
    std::string text = "if ";
    for (std::size_t p = 0; p < rule.when.size(); ++p) {
        const auto& variable = def.inputs[rule.when[p].variable];
        text += p == 0 ? "" : rule.any ? " or " : " and ";
        text += variable.name + (rule.when[p].negated ? " is not " : " is ") +
                variable.terms[rule.when[p].term].name;
    }
    const auto& output = def.outputs[rule.output];
    return text + " then " + output.name + " is " +
           (output.inference == Inference::kSugeno ? output.values[rule.then].name
                                                   : output.terms[rule.then].name);
}

}  // namespace

struct FuzzylitePeer::Parts {
    fl::Engine engine;
};

FuzzylitePeer::FuzzylitePeer(const FuzzyDef& def) : parts_(std::make_unique<Parts>()) {
    fl::Engine& engine = parts_->engine;
    for (const auto& variable : def.inputs) {
        auto* input = new fl::InputVariable(variable.name, variable.low, variable.high);
        for (const auto& term : variable.terms) {
            input->addTerm(trapezoid(term, variable.low, variable.high));
        }
        engine.addInputVariable(input);
    }
    for (const auto& out : def.outputs) {
        auto* output = new fl::OutputVariable(out.name, out.low, out.high);
        output->setDefaultValue(out.otherwise);
        if (out.inference == Inference::kSugeno) {
            for (const auto& value : out.values) {
                output->addTerm(new fl::Constant(value.name, value.constant));
            }
            output->setDefuzzifier(new fl::WeightedAverage("TakagiSugeno"));
            output->setAggregation(fl::null);
        } else {
            for (const auto& term : out.terms) {
                output->addTerm(trapezoid(term, out.low, out.high));
            }
            output->setDefuzzifier(new fl::Centroid(out.samples));
            output->setAggregation(new fl::Maximum);
        }
        engine.addOutputVariable(output);
    }
    auto* rules = new fl::RuleBlock;
    rules->setConjunction(new fl::Minimum);
    rules->setDisjunction(new fl::Maximum);
    rules->setActivation(new fl::General);
    if (def.outputs[0].inference == Inference::kMamdani) {
        rules->setImplication(new fl::Minimum);
    }
    for (const Rule& rule : def.rules) {
        rules->addRule(fl::Rule::parse(text_of_rule(def, rule), &engine));
    }
    engine.addRuleBlock(rules);
    std::string status;
    if (!engine.isReady(&status)) {
        throw std::runtime_error("fuzzylite is not ready: " + status);
    }
}

FuzzylitePeer::~FuzzylitePeer() = default;

double FuzzylitePeer::evaluate(const float* const* in, std::size_t agent) {
    fl::Engine& engine = parts_->engine;
    for (std::size_t k = 0; k < engine.numberOfInputVariables(); ++k) {
        engine.getInputVariable(k)->setValue(static_cast<fl::scalar>(in[k][agent]));
    }
    engine.process();
    return engine.getOutputVariable(0)->getValue();
}

}  // namespace zoned::bench
