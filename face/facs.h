// From words to muscles: the Facial Action Coding System (Ekman and Friesen) and expressions.
//
// FACS describes a face by numbered action units, what single muscles or small groups of them do.
// A string of them is read as
//
//   unit [+ unit]...        unit = [side] [lip] number [intensity]
//   side       L or R: only that side of the subject; else both
//   lip        T (top) or B (bottom): only that lip, for units that have both
//   intensity  A trace, B slight, C marked, D severe, E maximum = 0.2, 0.4, 0.6, 0.8, 1;
//              or a percentage, 12:60%; none says E
//
// for example 1+2+5B+26 (surprise) or R12A+R14A (contempt). Where several units want one muscle,
// the strongest wins: the order has no effect and nothing exceeds 1. What cannot be done is
// refused, never dropped: units of head, eyes, tongue and breath have no muscle here.
//
// Expressions are strings of action units as published; those of the name `waters:` are the macros
// of Waters' own geometric face, which pulls by muscle and knows neither units nor jaw.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "face/simulator.h"

namespace zygoma {

// What a face is told to do: muscles that are not named are slack.
struct Pose {
  std::map<std::string, double> contraction;  // [0, 1] by muscle
  double jaw = 0.0;                           // [0, 1] of Jaw::full_rad
};

enum class Lip { kBoth, kTop, kBottom };

// A share of a muscle that a unit takes, on both sides.
struct ActionPull {
  const char* muscle;  // without side
  double weight;       // contraction at full intensity
  Lip lip = Lip::kBoth;
};

struct ActionUnit {
  int number = 0;
  const char* name = "";
  const char* group = "";  // upper, vertical, horizontal, oblique, orbital, miscellaneous
  std::vector<ActionPull> pulls;
  double jaw = 0.0;
  bool one_sided = false;  // only ever of one side
};

// Those this face can do, by number.
const std::vector<ActionUnit>& action_units();

struct Expression {
  std::string name;   // "surprise", "waters:surprise"
  std::string units;  // as action units; empty for neutral and for those given by muscle
  Pose pose;
};

const std::vector<Expression>& expressions();

// All throw InputError naming what is wrong with the text.
Pose pose_of_action_units(const std::string& text);
Pose pose_of_expression(const std::string& name);
// "zygomaticus_major=0.6,mentalis_L=1,jaw=0.2"; a muscle without side stands for both.
Pose pose_of_muscles(const std::string& text);
// Any of the three.
Pose pose_of(const std::string& text);

// For a face that has these muscles; throws InputError naming one that it has not.
Controls controls_of(const Pose& pose, const Anatomy& anatomy);

}  // namespace zygoma
