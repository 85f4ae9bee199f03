"""What acts on a press on springs beside its springs: drive train, friction of bearings, loads in their phases."""
