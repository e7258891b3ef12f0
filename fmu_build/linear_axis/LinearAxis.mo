model LinearAxis "Plant of a linear servo axis: a mass with viscous friction under a drive's force"
  parameter Real mass(unit = "kg") = 95.1089 "Moving mass, the motor's inertia included";
  parameter Real viscous_friction(unit = "N.s/m") = 203.5034 "Viscous friction coefficient";
  parameter Real force_gain(unit = "N/V") = 35.1507 "Force of the drive a volt";
  input Real voltage(unit = "V") "Voltage at the drive";
  input Real port_force(unit = "N") "Force from outside";
  output Real force(unit = "N") "Force of the drive";
  Real position(unit = "m", start = 0, fixed = true);
  Real velocity(unit = "m/s", start = 0, fixed = true);
equation
  force = force_gain * voltage;
  der(position) = velocity;
  mass * der(velocity) = force + port_force - viscous_friction * velocity;
end LinearAxis;
