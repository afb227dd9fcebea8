/** What the page is told of an arm (`model_facts` of robots/kit/arms/described.py). Lengths in m, angles in rad. */

/** A revolute joint: the fixed transform before it (4 x 4, row by row), its axis there (unit length), its limits. */
export interface JointFacts {
  name: string;
  origin: readonly number[];
  axis: readonly number[];
  low: number;
  high: number;
  velocity: number; // rad/s
}
/** An axis-aligned box in the frame of the base. */
export interface BoxFacts {
  name: string;
  low: readonly number[];
  high: readonly number[];
}
/** A capsule in the frame that moves with joint number `joint`. */
export interface LimbFacts {
  name: string;
  joint: number;
  begin: readonly number[];
  end: readonly number[];
  radius: number;
  spared: readonly string[]; // boxes to which it is bolted
}
/**
 * The arm as its planner in Python has it. Python reads the URDF, and both sides compute with these numbers: a second
 * reader could differ in what it makes of soft limits, fixed joints or angles, and DOMParser is in no worker and not in Node.
 */
export interface ArmFacts {
  joints: readonly JointFacts[];
  boxes: readonly BoxFacts[];
  motion: {
    tool: readonly number[]; // from the last joint to the tool, 4 x 4, row by row
    limbs: readonly LimbFacts[];
    clearance_m: number;
    acceleration_s: number; // a joint may reach its full speed within this time
    scale: number; // the share of full speed if none is given
    scale_range: readonly number[];
    limit_s: number; // longest that one motion may take
  };
}
