"""Transcription for CasADi: kinematics as expressions, contacts as callbacks."""
